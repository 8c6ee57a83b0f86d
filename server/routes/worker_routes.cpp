// The protocol of the workers. A worker authenticates with a token of the scope work, asks for a lease, and names the
// lease's own token in every request for the job. A worker that lost the lease gets lease-lost.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/problem.hpp"
#include "api/version.hpp"
#include "api/worker_protocol.hpp"
#include "server/jobs/blob_response.hpp"
#include "server/jobs/job_json.hpp"
#include "server/jobs/submission.hpp"
#include "server/jobs/worker_caches.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr std::uint64_t largest_message = 64 << 10;

tl::unexpected<Error> wrong_type(const char* key, const char* wanted) {
  return fail(Code::bad_usage, std::string("not ") + wanted, key, "see /api/v1/openapi.yaml");
}

// Members of a message; an absent one is empty, false or 0. Unknown members may come from a newer worker. A string is
// cut to the length that a log or a page can show.
Result<std::string> text_of(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end()) return std::string();
  if (!it->is_string()) return wrong_type(key, "a string");
  return it->get<std::string>().substr(0, 2000);
}

Result<std::vector<std::string>> texts_of(const json& object, const char* key) {
  std::vector<std::string> texts;
  const auto it = object.find(key);
  if (it == object.end()) return texts;
  if (!it->is_array()) return wrong_type(key, "a list of strings");
  for (const json& item : *it) {
    if (!item.is_string()) return wrong_type(key, "a list of strings");
    texts.push_back(item.get<std::string>());
  }
  return texts;
}

Result<bool> flag_of(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end()) return false;
  if (!it->is_boolean()) return wrong_type(key, "true or false");
  return it->get<bool>();
}

Result<double> fraction_of(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end()) return 0.0;
  if (!it->is_number() || it->get<double>() < 0 || it->get<double>() > 1)
    return wrong_type(key, "a number from 0 to 1");
  return it->get<double>();
}

LeaseKey key_of(const Request& request) {
  return {request.at("job"), std::string(request.header("Vacuform-Lease"))};
}

Result<Response> take_lease(Service& service, Request& request) {
  VACUFORM_TRY(body, read_object(request, largest_message));
  VACUFORM_TRY(worker, text_of(body, "worker"));
  worker.resize(std::min<std::size_t>(worker.size(), 64));
  VACUFORM_TRY(sandbox, texts_of(body, "sandbox"));
  VACUFORM_TRY(stated, text_of(body, "version"));
  const auto protocol = body.find("protocol");
  if (protocol == body.end() || *protocol != json(worker_protocol)) {
    // Only numbers and letters: the text is untrusted.
    stated.resize(std::min<std::size_t>(stated.size(), 20));
    std::erase_if(
        stated, [](char c) { return c != '.' && c != '-' && (c < '0' || c > '9') && (c < 'a' || c > 'z'); });
    log_event("worker-refused", {{"worker", worker}, {"version", stated}});
    return fail(Code::conflict,
                "this server (" + std::string(version) + ") speaks protocol " +
                    std::to_string(worker_protocol) + " with workers, and the worker" +
                    (stated.empty() ? "" : " (" + stated + ")") + " another",
                "protocol", "install server and workers of the same version");
  }
  service.workers.seen(worker, sandbox, wall_clock());
  VACUFORM_TRY(lease, service.store.lease(worker));
  if (!lease) {
    return no_content();
  }
  const Job& job = lease->job;
  ordered_json inputs = inputs_json(job);
  for (const InputKind& kind : input_kinds)  // a worker gets no files that wait for a later print
    if (!uses(job.kind, kind)) inputs.erase(std::string(kind.name));
  const Input* scan = job.input("scan");
  log_event("job-leased", {{"job", job.id}, {"attempt", job.attempt}});
  return json_response(
      {{"job", job.id},
       {"kind", name(job.kind)},
       {"lease", lease->token},
       {"attempt", job.attempt},
       {"lease_seconds", service.lease_seconds},
       {"heartbeat_seconds", service.heartbeat_seconds},
       {"request", job.request},
       {"reference", job.reference},
       {"cache", service.caches && scan ? service.caches->key(job.owner, scan->blob.sha256) : ""},
       {"settings", ordered_json::parse(job.settings)},
       {"inputs", std::move(inputs)}});
}

Result<Response> get_input(Service& service, const Request& request) {
  VACUFORM_TRY(job, service.store.leased(key_of(request)));
  const std::string& which = request.at("input");
  const Input* input = job.input(which);
  if (!input)
    return fail(Code::not_found, "there is no such input", which, "ask for those that the lease names");
  VACUFORM_TRY(reader, service.store.open(input->blob));
  return blob_response(request, std::move(reader), "application/octet-stream", input->blob.sha256);
}

Result<Response> heartbeat(Service& service, Request& request) {
  VACUFORM_TRY(body, read_object(request, largest_message));
  std::optional<Stage> stage;
  VACUFORM_TRY(text, text_of(body, "stage"));
  if (!text.empty()) {
    stage = stage_from(text);
    if (!stage)
      return fail(Code::bad_usage, "there is no such stage: " + text, "stage",
                  "send scan, forming, flattening, printing or inspection");
  }
  VACUFORM_TRY(progress, fraction_of(body, "progress"));
  VACUFORM_TRY(cancel, service.store.heartbeat(key_of(request), stage, progress));
  return json_response({{"cancel", cancel}});
}

Result<Response> add_log(Service& service, Request& request) {
  VACUFORM_TRY(body, read_object(request, largest_message));
  const auto first = body.find("first");
  if (first == body.end() || !first->is_number_unsigned() || first->get<std::uint64_t>() > most_log_lines)
    return fail(Code::bad_usage, "there is no number of the first line", "first", "number lines from 0");
  VACUFORM_TRY(lines, texts_of(body, "lines"));
  VACUFORM_CHECK(service.store.log(key_of(request), first->get<int>(), lines));
  return json_response(ordered_json::object());
}

Result<Response> put_artifact(Service& service, Request& request) {
  const std::string& name = request.at("name");
  if (!artifact_kind(name))
    return fail(Code::bad_usage, "no artifact has this name", name.substr(0, 64),
                "see api/openapi.yaml for the names");
  if (request.header("Content-Length").empty())
    return problem_response({Code::bad_usage, "there is no Content-Length", name, "send the number of bytes"},
                            411);
  const LeaseKey key = key_of(request);
  VACUFORM_TRY(job, service.store.leased(key));  // before the bytes are read
  VACUFORM_TRY(upload, service.store.upload(Use::artifact));
  VACUFORM_CHECK(request.body->read([&](std::string_view piece) { return upload.write(piece); }));
  VACUFORM_CHECK(service.store.put_artifact(key, name, std::move(upload)));
  return json_response(ordered_json::object());
}

Response ended_as(const char* event, const Job& job) {
  ordered_json fields = {{"job", job.id}, {"state", name(job.state)}, {"attempt", job.attempt}};
  if (job.error) fields["problem"] = meaning(job.error->code).slug;
  log_event(event, fields);
  return json_response({{"state", name(job.state)}});
}

// nullopt if the worker does not state it.
Result<std::optional<int>> serious_warnings_of(const json& object) {
  constexpr std::uint64_t most = 1000;
  const auto it = object.find("serious_warnings");
  if (it == object.end()) return std::optional<int>();
  if (!it->is_number_unsigned() || it->get<std::uint64_t>() > most)
    return wrong_type("serious_warnings", "a number from 0 to 1000");
  return std::optional(it->get<int>());
}

Result<Response> complete_job(Service& service, Request& request) {
  VACUFORM_TRY(body, read_object(request, largest_message));
  VACUFORM_TRY(serious, serious_warnings_of(body));
  VACUFORM_TRY(job, service.store.complete(key_of(request), serious));
  return ended_as("job-completed", job);
}

Result<Response> fail_job(Service& service, Request& request) {
  VACUFORM_TRY(body, read_object(request, largest_message));
  VACUFORM_TRY(slug, text_of(body, "code"));
  const auto code = code_from(slug);
  if (!code)
    return fail(Code::bad_usage, "there is no such problem type: " + slug, "code",
                "send the last piece of a type of /problems/");
  VACUFORM_TRY(what, text_of(body, "what"));
  VACUFORM_TRY(where, text_of(body, "where"));
  VACUFORM_TRY(fix, text_of(body, "fix"));
  VACUFORM_TRY(crashed, flag_of(body, "crashed"));
  VACUFORM_TRY(again, flag_of(body, "retry"));
  const auto list = body.find("proposals");
  auto proposals = proposals_from(list == body.end() ? json() : *list);
  if (!proposals) return wrong_type("proposals", "a list of settings with texts");
  const Error error{*code, std::move(what), std::move(where), std::move(fix), {}, std::move(*proposals)};
  const Retry retry = crashed ? Retry::after_crash : again ? Retry::after_fault : Retry::never;
  VACUFORM_TRY(job, service.store.fail_job(key_of(request), error, retry));
  return ended_as("job-failed", job);
}

}  // namespace

void add_worker_routes(http::Router& router, Service& service) {
  const auto add = [&](const char* method, const std::string& tail, auto route,
                       std::uint64_t most_body = http::small_body) {
    add_guarded(
        router, service, Scope::work, method, "/api/v1/leases" + tail,
        [route](Service& s, Request& request, const Caller&) { return route(s, request); }, most_body);
  };
  const auto add_end = [&](const std::string& tail, const char* event, auto change) {
    add("POST", "/{job}/" + tail, [event, change](Service& s, Request& request) -> Result<Response> {
      VACUFORM_TRY(job, (s.store.*change)(key_of(request)));
      return ended_as(event, job);
    });
  };
  add("POST", "", take_lease);
  add("GET", "/{job}/inputs/{input}", get_input);
  add("POST", "/{job}/heartbeat", heartbeat);
  add("POST", "/{job}/log", add_log);
  add("PUT", "/{job}/artifacts/{name}", put_artifact, largest_artifact);
  add("POST", "/{job}/fail", fail_job);
  add("POST", "/{job}/complete", complete_job);
  add_end("cancelled", "job-cancelled", &Store::cancelled);
  add_end("release", "job-released", &Store::release);
}

}  // namespace vacuform
