#include <nlohmann/json.hpp>

#include "server/jobs/json_artifact.hpp"
#include "server/messages/problem.hpp"
#include "server/pages/app_files.hpp"
#include "server/pages/pages.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/job_changes.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

constexpr int recent_jobs = 10, longest_shown_log = 200;  // lines

Result<Response> list_jobs(Service& service, const Request&, const Caller& caller) {
  VACUFORM_TRY(page, service.store.list(recent_jobs, "", {.owner = caller.only()}, Detail::brief));
  return html_response(list_page(page.jobs));
}

Result<Response> show_job(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  VACUFORM_TRY(log, service.store.log_after(job.id, 0, longest_shown_log));
  const auto made = json_artifact(service.store, job, report_of(job.kind));
  VACUFORM_TRY(estimate, service.store.estimate(job));
  return html_response(job_page(job, made, log, estimate));
}

}  // namespace

void add_page_routes(http::Router& router, Service& service) {
  add_guarded(
      router, service, Scope::read, "GET", "/",
      [](Service&, Request& request, const Caller&) -> Result<Response> { return app_page(request); });
  add_guarded(router, service, Scope::read, "GET", "/jobs", list_jobs);
  add_guarded(router, service, Scope::read, "GET", "/jobs/{id}", show_job);
  add_guarded(router, service, Scope::submit, "POST", "/jobs/{id}/cancel",
              cancelling([](const Job& job) { return see_other("/jobs/" + job.id); }));
  add_guarded(router, service, Scope::submit, "POST", "/jobs/{id}/delete",
              deleting([](const Job&) { return see_other("/jobs"); }));
}

}  // namespace vacuform
