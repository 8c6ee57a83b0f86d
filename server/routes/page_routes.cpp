#include <nlohmann/json.hpp>

#include "server/jobs/json_artifact.hpp"
#include "server/jobs/submission.hpp"
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

constexpr int longest_shown_log = 200;  // lines

std::vector<Job> recent_jobs(Store& store, const Caller& caller) {
  auto page = store.list(10, "", {.owner = caller.only()}, Detail::brief);
  return page ? std::move(page->jobs) : std::vector<Job>();
}

// The form with what it offers.
Response form(Service& service, const Caller& caller, const std::optional<Error>& error = std::nullopt,
              const std::map<std::string, std::string>& fields = {}) {
  auto profiles = service.store.list_profiles(100, "");
  return html_response(form_page(recent_jobs(service.store, caller),
                                 profiles ? std::move(profiles->profiles) : std::vector<Profile>(), error,
                                 fields));
}

Result<Response> submit(Service& service, Request& request, const Caller& caller) {
  std::map<std::string, std::string> fields;
  auto submission = read_submission(service, request, caller, fields);
  if (!submission) return form(service, caller, submission.error(), fields);
  auto job = create_job(service, std::move(*submission), caller);
  if (!job) return form(service, caller, job.error(), fields);
  return see_other("/jobs/" + job->id);
}

Result<Response> show_form(Service& service, const Request&, const Caller& caller) {
  return form(service, caller);
}

Result<Response> show_job(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  VACUFORM_TRY(log, service.store.log_after(job.id, 0, longest_shown_log));
  const auto made = json_artifact(service.store, job, report_of(job.kind));
  VACUFORM_TRY(outlook, service.store.outlook(job));
  return html_response(job_page(job, made, log, outlook));
}

}  // namespace

void add_page_routes(http::Router& router, Service& service) {
  const auto add = [&](Scope scope, const char* method, const char* pattern, const GuardedHandler& handler,
                       std::uint64_t most_body = http::small_body) {
    add_guarded(router, service, scope, method, pattern, handler, most_body);
  };
  add(Scope::read, "GET", "/",
      [](Service&, Request& request, const Caller&) -> Result<Response> { return app_page(request); });
  add(Scope::read, "GET", "/jobs", show_form);
  add(Scope::submit, "POST", "/jobs", submit, largest_form());
  add(Scope::read, "GET", "/jobs/{id}", show_job);
  add(Scope::submit, "POST", "/jobs/{id}/cancel",
      cancelling([](const Job& job) { return see_other("/jobs/" + job.id); }));
  add(Scope::submit, "POST", "/jobs/{id}/delete", deleting([](const Job&) { return see_other("/jobs"); }));
}

}  // namespace vacuform
