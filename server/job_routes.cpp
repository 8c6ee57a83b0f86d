// The API that people and programs use; api/openapi.yaml describes it.
#include <charconv>
#include <nlohmann/json.hpp>

#include "api/log.hpp"
#include "api/settings.hpp"
#include "server/assets.hpp"
#include "server/job_json.hpp"
#include "server/problem.hpp"
#include "server/service.hpp"
#include "server/submission.hpp"
#include "server/zip.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

Result<Response> create_job(Service& service, Request& request) {
  std::map<std::string, std::string> fields;
  VACUFORM_TRY(submission, read_submission(request, service.store, fields));
  VACUFORM_TRY(job, service.store.create(std::move(submission)));
  log_event("job-created", {{"job", job.id}});
  Response response = json_response(job_json(job), 202);
  response.set("Location", "/api/v1/jobs/" + job.id);
  return response;
}

Result<Response> list_jobs(Service& service, const Request& request) {
  int limit = 20;
  if (const std::string text = request.query_value("limit"); !text.empty()) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), limit);
    if (error != std::errc() || end != text.data() + text.size() || limit < 1 || limit > 100)
      return fail(Code::bad_usage, "limit is not a number from 1 to 100: " + text, "limit",
                  "give for example 20");
  }
  VACUFORM_TRY(page, service.store.list(limit, request.query_value("cursor")));
  ordered_json jobs = ordered_json::array();
  for (const Job& job : page.jobs) jobs.push_back(job_json(job));
  return json_response({{"jobs", jobs}, {"next", page.next ? ordered_json(*page.next) : ordered_json()}});
}

Result<Response> list_artifacts(Service& service, const Request& request) {
  VACUFORM_TRY(job, service.store.job(request.at("id")));
  ordered_json artifacts = ordered_json::array();
  for (const auto& artifact : job.artifacts) artifacts.push_back(artifact_json(job, artifact));
  return json_response({{"artifacts", artifacts}});
}

Result<Response> get_artifact(Service& service, const Request& request) {
  VACUFORM_TRY(job, service.store.job(request.at("id")));
  const ArtifactKind* kind = artifact_kind(request.at("name"));
  for (const auto& artifact : job.artifacts) {
    if (!kind || artifact.name != kind->name) continue;
    VACUFORM_TRY(file, service.store.open(artifact.blob));
    VACUFORM_TRY(response, http::file_response(request, std::move(file), std::string(kind->media_type),
                                               artifact.blob.sha256));
    response.set("X-Content-Type-Options", "nosniff");
    // An SVG opened on its own must not run what a pattern brought along.
    response.set("Content-Security-Policy",
                 "default-src 'none'; img-src data:; style-src 'unsafe-inline'; sandbox");
    return response;
  }
  return fail(Code::not_found, "the job has no such artifact", request.at("id"),
              "see /api/v1/jobs/" + request.at("id") + "/artifacts");
}

Result<Response> get_zip(Service& service, const Request& request) {
  VACUFORM_TRY(job, service.store.job(request.at("id")));
  if (job.artifacts.empty())
    return fail(Code::not_found, "the job has no artifacts yet", job.id, "wait until it has succeeded");
  VACUFORM_TRY(file, make_zip(service.store, job));
  VACUFORM_TRY(response, http::file_response(request, std::move(file), "application/zip", zip_etag(job)));
  response.set("Content-Disposition", "attachment; filename=\"vacuform-" + job.id + ".zip\"");
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

}  // namespace

void add_job_routes(http::Router& router, Service& service) {
  Service* const s = &service;
  router.add("POST", "/api/v1/jobs", [s](Request& request) { return create_job(*s, request); });
  router.add("GET", "/api/v1/jobs", [s](Request& request) { return list_jobs(*s, request); });
  router.add("GET", "/api/v1/jobs/{id}", [s](Request& request) -> Result<Response> {
    VACUFORM_TRY(job, s->store.job(request.at("id")));
    return json_response(job_json(job));
  });
  router.add("POST", "/api/v1/jobs/{id}/cancel", [s](Request& request) -> Result<Response> {
    VACUFORM_TRY(job, s->store.cancel(request.at("id")));
    log_event("job-cancel-asked", {{"job", job.id}, {"state", name(job.state)}});
    return json_response(job_json(job));
  });
  router.add("DELETE", "/api/v1/jobs/{id}", [s](Request& request) -> Result<Response> {
    VACUFORM_CHECK(s->store.remove(request.at("id")));
    log_event("job-deleted", {{"job", request.at("id")}});
    Response response;
    response.status = 204;
    return response;
  });
  router.add("GET", "/api/v1/jobs/{id}/artifacts",
             [s](Request& request) { return list_artifacts(*s, request); });
  router.add("GET", "/api/v1/jobs/{id}/artifacts/{name}",
             [s](Request& request) { return get_artifact(*s, request); });
  router.add("GET", "/api/v1/jobs/{id}/artifacts.zip",
             [s](Request& request) { return get_zip(*s, request); });
  router.add("GET", "/api/v1/settings-schema", [](Request&) -> Result<Response> {
    Response response = json_response(settings_schema());
    response.media_type = "application/schema+json";
    return response;
  });
  router.add("GET", "/api/v1/openapi.yaml", [](Request&) -> Result<Response> {
    return http::text_response("application/yaml", std::string(openapi_yaml()));
  });
  router.add("GET", "/healthz", [](Request&) -> Result<Response> {
    return json_response({{"status", "ok"}});
  });
}

http::Router all_routes(Service& service) {
  http::Router router;
  add_job_routes(router, service);
  add_worker_routes(router, service);
  add_page_routes(router, service);
  return router;
}

}  // namespace vacuform
