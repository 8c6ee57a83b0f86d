#include <nlohmann/json.hpp>

#include "api/log.hpp"
#include "server/pages/pages.hpp"
#include "server/problem.hpp"
#include "server/service.hpp"
#include "server/submission.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

constexpr std::uint64_t largest_report = 4 << 20;
constexpr int longest_shown_log = 200;  // lines

std::vector<Job> recent_jobs(Store& store, const Caller& caller) {
  auto page = store.list(10, "", caller.only());
  return page ? std::move(page->jobs) : std::vector<Job>();
}

Result<Response> submit(Service& service, Request& request, const Caller& caller) {
  std::map<std::string, std::string> fields;
  auto submission = read_submission(service, request, caller, fields);
  if (!submission)
    return html_response(form_page(recent_jobs(service.store, caller), submission.error(), fields));
  auto job = service.store.create(std::move(*submission));
  if (!job) return html_response(form_page(recent_jobs(service.store, caller), job.error(), fields));
  log_event("job-created", {{"job", job->id}, {"token", caller.token}});
  return see_other("/jobs/" + job->id);
}

// report.json of a job, or null when it has none that can be read.
nlohmann::json report_of(Store& store, const Job& job) {
  for (const auto& artifact : job.artifacts) {
    if (artifact.name != "report.json" || artifact.blob.bytes > largest_report) continue;
    const auto file = store.open(artifact.blob);
    std::string text(artifact.blob.bytes, '\0');
    if (!file || file->read_at(0, text).value_or(0) != text.size()) return nullptr;
    auto report = nlohmann::json::parse(text, nullptr, false);
    return report.is_discarded() ? nlohmann::json() : report;
  }
  return nullptr;
}

Result<Response> show_form(Service& service, const Request&, const Caller& caller) {
  return html_response(form_page(recent_jobs(service.store, caller)));
}

Result<Response> show_job(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request, caller));
  VACUFORM_TRY(log, service.store.log_after(job.id, 0, longest_shown_log));
  return html_response(job_page(job, report_of(service.store, job), log));
}

Result<Response> cancel(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(seen, job_for(service, request, caller));
  VACUFORM_TRY(job, service.store.cancel(seen.id));
  log_event("job-cancel-asked", {{"job", job.id}, {"state", name(job.state)}, {"token", caller.token}});
  return see_other("/jobs/" + job.id);
}

Result<Response> remove(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(seen, job_for(service, request, caller));
  VACUFORM_CHECK(service.store.remove(seen.id));
  log_event("job-deleted", {{"job", seen.id}, {"token", caller.token}});
  return see_other("/");
}

}  // namespace

void add_page_routes(http::Router& router, Service& service) {
  const auto add = [&](Scope scope, const char* method, const char* pattern, const GuardedHandler& handler) {
    add_guarded(router, service, scope, method, pattern, handler);
  };
  add(Scope::read, "GET", "/", show_form);
  add(Scope::read, "GET", "/jobs",
      [](Service&, Request&, const Caller&) -> Result<Response> { return see_other("/"); });
  add(Scope::submit, "POST", "/jobs", submit);
  add(Scope::read, "GET", "/jobs/{id}", show_job);
  add(Scope::submit, "POST", "/jobs/{id}/cancel", cancel);
  add(Scope::submit, "POST", "/jobs/{id}/delete", remove);
}

}  // namespace vacuform
