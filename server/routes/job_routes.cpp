// The API that people and programs use; api/openapi.yaml describes it.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/text.hpp"
#include "api/base/utf8.hpp"
#include "api/job_text.hpp"
#include "server/jobs/blob_response.hpp"
#include "server/jobs/download_name.hpp"
#include "server/jobs/job_json.hpp"
#include "server/jobs/submission.hpp"
#include "server/jobs/zip.hpp"
#include "server/messages/problem.hpp"
#include "server/messages/range.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/job_changes.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

constexpr std::size_t longest_searched = 100;  // characters

Result<Response> no_room(Service& service, const Caller& caller, const Error& error) {
  VACUFORM_TRY(seconds, service.store.seconds_until_room(caller.owner));
  Response response = problem_response(error);
  set_retry_after(response, seconds);
  return response;
}

// Says what a submission would be as a job, and keeps nothing.
Result<Response> validate_job(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(submission, read_submission(service, request, caller));
  if (const auto free = check_reference(service, submission); !free)
    return free.error().code == Code::conflict ? problem_response(free.error(), 422)
                                               : Result<Response>(tl::make_unexpected(free.error()));
  VACUFORM_TRY(plan, plan_of(submission, service.store));
  return json_response(plan);
}

Result<Response> submit_job(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(submission, read_submission(service, request, caller));
  auto made = create_job(service, std::move(submission), caller);
  // The key of another submission, as the draft of Idempotency-Key wants it told; or the reference of another head.
  if (!made && made.error().code == Code::conflict) return problem_response(made.error(), 422);
  if (!made && made.error().code == Code::busy) return no_room(service, caller, made.error());
  VACUFORM_TRY(job, std::move(made));
  Response response = json_response(job_json(job), 202);
  response.set("Location", "/api/v1/jobs/" + job.id);
  return response;
}

// {"reference": "CASE-12", "rescan": false}
Result<Response> change_reference(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(seen, job_for(service, request.at("id"), caller));
  VACUFORM_TRY(object, read_object(request, http::small_body));
  const auto text = object.find("reference"), rescan = object.find("rescan");
  if (text == object.end() || !text->is_string() || (rescan != object.end() && !rescan->is_boolean()) ||
      object.size() != (rescan == object.end() ? 1u : 2u))
    return fail(Code::bad_usage, "not a change of a job's reference", "request body",
                R"(send {"reference": "CASE-12"}, and "rescan": true for another scan of the same patient)");
  NewReference change;
  VACUFORM_TRY(reference, clean_reference(text->get<std::string>()));
  change.text = std::move(reference);
  change.rescan = rescan != object.end() && rescan->get<bool>();
  change.owner = caller.owner;
  change.token = caller.token;
  std::optional<http::Refusal> refusal;
  auto changed = service.store.set_reference(seen.id, change, precondition(request, refusal));
  if (refusal) return http::refused_response(std::move(*refusal));
  VACUFORM_TRY(job, std::move(changed));
  if (job.version != seen.version)
    log_event("job-reference-changed", {{"job", job.id}, {"token", caller.token}});
  Response response = json_response(job_json(job));
  response.set("ETag", etag_of(job));
  return response;
}

Result<std::vector<JobState>> states_of(std::string_view text) {
  std::vector<JobState> states;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find(','));
    const auto state = job_state_from(one);
    if (!state)
      return fail(Code::bad_usage, "there is no such state: " + std::string(one.substr(0, 64)), "state",
                  "give for example queued,running");
    states.push_back(*state);
    text.remove_prefix(std::min(one.size() + 1, text.size()));
  }
  return states;
}

Result<std::optional<Millis>> time_of(const Request& request, const char* name) {
  const std::string text = request.query_value(name);
  if (text.empty()) return std::optional<Millis>();
  const auto time = from_rfc3339(text);
  if (!time)
    return fail(Code::bad_usage, "not a time as RFC 3339 has it: " + text.substr(0, 64), name,
                "give for example 2026-01-31T12:00:00Z");
  return time;
}

// The filters of a list, within what the caller may see.
Result<JobFilter> filter_of(const Request& request, const Caller& caller) {
  JobFilter filter;
  filter.owner = caller.only();
  const std::string owner = request.query_value("owner");
  if (filter.owner && !owner.empty() && owner != *filter.owner)
    return fail(Code::forbidden, "only an administrator lists the jobs of another owner", "owner",
                "leave it out");
  if (!owner.empty()) filter.owner = owner;
  VACUFORM_TRY(states, states_of(request.query_value("state")));
  filter.states = std::move(states);
  const std::string kind = request.query_value("kind");
  if (!kind.empty() && !(filter.kind = job_kind_from(kind)))
    return fail(Code::bad_usage, "there is no such kind of job: " + kind.substr(0, 64), "kind",
                "give print, inspection or layout");
  VACUFORM_TRY(after, time_of(request, "created_after"));
  VACUFORM_TRY(before, time_of(request, "created_before"));
  filter.created_after = after;
  filter.created_before = before;
  filter.text = std::string(trimmed(request.query_value("text")));
  const auto points = code_points(filter.text);
  if (!points || points->size() > longest_searched)
    return fail(Code::bad_usage,
                "the text is not UTF-8, or longer than " + std::to_string(longest_searched) + " characters",
                "text", "give a part of the reference, the note or the id");
  return filter;
}

Result<Response> list_jobs(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(asked, page_asked(request));
  VACUFORM_TRY(filter, filter_of(request, caller));
  const std::string full = request.query_value("full");
  if (!full.empty() && full != "true" && full != "false")
    return fail(Code::bad_usage, "full is neither true nor false", "full", "send true");
  const Detail detail = full == "true" ? Detail::full : Detail::brief;
  VACUFORM_TRY(page, service.store.list(asked.limit, asked.cursor, filter, detail));
  ordered_json jobs = ordered_json::array();
  for (const Job& job : page.jobs) jobs.push_back(job_json(job, detail));
  return page_response("jobs", std::move(jobs), page.next);
}

Result<Response> list_artifacts(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  ordered_json artifacts = ordered_json::array();
  for (const auto& artifact : job.artifacts) artifacts.push_back(artifact_json(job, artifact));
  return json_response({{"artifacts", artifacts}});
}

Result<Response> get_artifact(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  const ArtifactKind* kind = artifact_kind(request.at("name"));
  for (const auto& artifact : job.artifacts) {
    if (!kind || artifact.name != kind->name) continue;
    VACUFORM_TRY(reader, service.store.open(artifact.blob));
    VACUFORM_TRY(response, blob_response(request, std::move(reader), std::string(kind->media_type),
                                         artifact.blob.sha256));
    response.set("Content-Disposition", content_disposition("inline", job, artifact.name));
    response.set("X-Content-Type-Options", "nosniff");
    // An SVG opened on its own must not run what a pattern brought along.
    response.set("Content-Security-Policy",
                 "default-src 'none'; img-src data:; style-src 'unsafe-inline'; sandbox");
    return response;
  }
  return fail(Code::not_found, "the job has no such artifact", request.at("id"),
              "see /api/v1/jobs/" + request.at("id") + "/artifacts");
}

std::string quoted(const std::string& etag) {
  std::string text("\"");
  return text.append(etag).append("\"");
}

Response unchanged(const std::string& etag) {
  Response response;
  response.status = 304;
  response.set("ETag", quoted(etag));
  response.set("Cache-Control", "private, no-cache");
  return response;
}

Result<Response> get_zip(Service& service, Checksums& checksums, const Request& request,
                         const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  if (job.artifacts.empty())
    return fail(Code::not_found, "the job has no artifacts yet", job.id, "wait until it has succeeded");
  const std::string etag = zip_etag(job);
  if (http::names_etag(request.header("If-None-Match"), quoted(etag))) return unchanged(etag);
  std::vector<Zip::Entry> entries;
  for (const auto& artifact : job.artifacts) entries.push_back({artifact.name, artifact.blob, 0});
  if (!request.head_only) {  // whose length is the same
    VACUFORM_TRY(crc, checksums.of(service.store, job));
    for (std::size_t i = 0; i < entries.size(); ++i) entries[i].crc = crc[i];
  }
  auto zip = std::make_shared<Zip>(std::move(entries),
                                   [&store = service.store](const Blob& blob) { return store.open(blob); });
  const std::uint64_t bytes = zip->bytes();
  VACUFORM_TRY(response, http::source_response(request, std::move(zip), bytes, "application/zip", etag));
  response.set("Content-Disposition", content_disposition("attachment", job, "artifacts.zip"));
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

Result<Response> get_log(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  VACUFORM_TRY(after, query_number(request, "after", 0, 0, std::numeric_limits<std::int64_t>::max()));
  VACUFORM_TRY(limit, query_number(request, "limit", 200, 1, 1000));
  VACUFORM_TRY(lines, service.store.log_after(job.id, after, static_cast<int>(limit)));
  ordered_json list = ordered_json::array();
  for (const LogLine& line : lines) list.push_back(log_line_json(line));
  return json_response({{"lines", list},
                        {"next", lines.empty() ? after : lines.back().number},
                        {"ended", ended(job.state) && lines.size() < static_cast<std::size_t>(limit)}});
}

}  // namespace

void add_job_routes(http::Router& router, Service& service) {
  const auto add = [&](Scope scope, const char* method, const std::string& tail,
                       const GuardedHandler& handler, std::uint64_t most_body = http::small_body) {
    add_guarded(router, service, scope, method, "/api/v1/jobs" + tail, handler, most_body);
  };
  add(Scope::submit, "POST", "", submit_job, largest_form());
  add_guarded(router, service, Scope::submit, "POST", "/api/v1/validate", validate_job, largest_form());
  add(Scope::read, "GET", "?limit&cursor&state&kind&owner&created_after&created_before&text&full", list_jobs);
  add(Scope::read, "GET", "/{id}/log?after&limit", get_log);
  add(Scope::submit, "POST", "/{id}/cancel",
      cancelling([](const Job& job) { return json_response(job_json(job)); }));
  add(Scope::submit, "PATCH", "/{id}", change_reference);
  add(Scope::submit, "DELETE", "/{id}", deleting([](const Job&) { return no_content(); }));
  add(Scope::read, "GET", "/{id}/artifacts", list_artifacts);
  add(Scope::read, "GET", "/{id}/artifacts/{name}", get_artifact);
  add(Scope::read, "GET", "/{id}/artifacts.zip",
      [checksums = std::make_shared<Checksums>()](Service& s, const Request& request, const Caller& caller) {
        return get_zip(s, *checksums, request, caller);
      });
}

}  // namespace vacuform
