#include <nlohmann/json.hpp>

#include "server/assets.hpp"
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

Response see_other(const std::string& place) {
  Response response;
  response.status = 303;
  response.set("Location", place);
  return response;
}

std::vector<Job> recent_jobs(Store& store) {
  auto page = store.list(10, "");
  return page ? std::move(page->jobs) : std::vector<Job>();
}

Result<Response> submit(Service& service, Request& request) {
  std::map<std::string, std::string> fields;
  auto submission = read_submission(request, service.store, fields);
  if (!submission) return html_response(form_page(recent_jobs(service.store), submission.error(), fields));
  auto job = service.store.create(std::move(*submission));
  if (!job) return html_response(form_page(recent_jobs(service.store), job.error(), fields));
  log_event("job-created", {{"job", job->id}});
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

Result<Response> show_job(Service& service, const Request& request) {
  VACUFORM_TRY(job, service.store.job(request.at("id")));
  return html_response(job_page(job, report_of(service.store, job)));
}

}  // namespace

void add_page_routes(http::Router& router, Service& service) {
  Service* const s = &service;
  router.add("GET", "/",
             [s](Request&) -> Result<Response> { return html_response(form_page(recent_jobs(s->store))); });
  router.add("GET", "/jobs", [](Request&) -> Result<Response> { return see_other("/"); });
  router.add("POST", "/jobs", [s](Request& request) { return submit(*s, request); });
  router.add("GET", "/jobs/{id}", [s](Request& request) { return show_job(*s, request); });
  router.add("POST", "/jobs/{id}/cancel", [s](Request& request) -> Result<Response> {
    VACUFORM_TRY(job, s->store.cancel(request.at("id")));
    log_event("job-cancel-asked", {{"job", job.id}, {"state", name(job.state)}});
    return see_other("/jobs/" + job.id);
  });
  router.add("POST", "/jobs/{id}/delete", [s](Request& request) -> Result<Response> {
    VACUFORM_CHECK(s->store.remove(request.at("id")));
    log_event("job-deleted", {{"job", request.at("id")}});
    return see_other("/");
  });
  router.add("GET", "/problems/",
             [](Request&) -> Result<Response> { return html_response(problems_page()); });
  router.add("GET", "/problems/{slug}", [](Request& request) -> Result<Response> {
    const auto code = code_from(request.at("slug"));
    if (!code) return fail(Code::not_found, "there is no such problem type", {}, "see /problems/");
    return html_response(problem_page(*code));
  });
  router.add("GET", "/style.css", [](Request&) -> Result<Response> {
    Response response = http::text_response("text/css; charset=utf-8", std::string(style_css()));
    response.set("X-Content-Type-Options", "nosniff");
    return response;
  });
}

Response refuse(const Request& request, const http::Refusal& refusal) {
  const bool page =
      !request.path.starts_with("/api/") && request.header("Accept").find("text/html") != std::string::npos;
  if (!page) return problem_response(refusal.error, refusal.status);
  Page shown;
  shown.title = std::string(meaning(refusal.error.code).title);
  shown.status = refusal.status;
  shown.main =
      "<h1>This did not work</h1>\n" + problem_box(refusal.error) + "<p><a href=\"/\">To the start</a></p>\n";
  return html_response(shown);
}

}  // namespace vacuform
