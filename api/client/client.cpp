#include "api/client/client.hpp"

#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "api/base/json_text.hpp"
#include "api/base/log.hpp"
#include "api/base/sha256.hpp"
#include "api/job_text.hpp"
#include "api/problem.hpp"
#include "api/settings.hpp"
#include "api/version.hpp"
#include "api/worker_protocol.hpp"

namespace vacuform {

using nlohmann::json;

namespace {

constexpr std::chrono::seconds short_call{10};

Error not_vacuform(const std::string& what) {
  return {Code::internal, "the server's answer is not of the documented form: " + what, "",
          "check that the server and this program are of the same version"};
}

// Fields of a JSON object that another machine wrote: absent or of the wrong type gives the fallback.
double number_of(const json& object, const char* key, double fallback) {
  const auto it = object.find(key);
  return it != object.end() && it->is_number() ? it->get<double>() : fallback;
}
std::uint64_t count_of(const json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_number_unsigned() ? it->get<std::uint64_t>() : 0;
}
double fraction_of(const json& object, const char* key) {
  return std::clamp(number_of(object, key, 0), 0.0, 1.0);
}

// 32 random hexadecimal digits.
std::string random_key() {
  std::array<unsigned char, 16> bytes;
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) std::abort();
  std::string text;
  for (const unsigned byte : bytes)
    for (const unsigned digit : {byte >> 4, byte & 15u}) text += "0123456789abcdef"[digit];
  return text;
}

// Text from elsewhere need not be UTF-8.
std::string written(const json& object) {
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

// A name that is safe in a local path or a path of the server.
bool plain(const std::string& id, std::size_t longest) {
  return !id.empty() && id.size() <= longest &&
         id.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_") ==
             std::string::npos;
}

Result<HttpResponse> good(Result<HttpResponse> response) {
  if (response && (response->status < 200 || response->status > 299))
    return tl::make_unexpected(error_of(*response));
  return response;
}

Result<RemoteJob> job_from(const HttpResponse& response) {
  const json object = json::parse(response.body, nullptr, false);
  if (!object.is_object()) return tl::make_unexpected(not_vacuform("a job is not a JSON object"));
  RemoteJob job;
  job.id = text_of(object, "id");
  const auto state = job_state_from(text_of(object, "state"));
  if (!plain(job.id, 64) || !state)
    return tl::make_unexpected(not_vacuform("a job without an id or a known state"));
  job.state = *state;
  job.stage = stage_from(text_of(object, "stage"));
  job.progress = fraction_of(object, "progress");
  job.stage_progress = fraction_of(object, "stage_progress");
  if (const auto list = object.find("artifacts"); list != object.end() && list->is_array())
    for (const json& a : *list)
      if (a.is_object() && artifact_kind(text_of(a, "name")))
        job.artifacts.push_back({text_of(a, "name"), count_of(a, "bytes"), text_of(a, "sha256")});
  if (const auto problem = object.find("problem"); problem != object.end() && problem->is_object())
    job.problem = error_of({0, {}, problem->dump()});
  return job;
}

LeasedInput input_from(const InputKind& kind, const json& from) {
  LeasedInput input{std::string(kind.name), text_of(from, "extension"), count_of(from, "bytes"),
                    text_of(from, "sha256")};
  if (!input.extension.empty() && input.extension.front() == '.') input.extension.erase(0, 1);
  if (!plain(input.extension, 8)) input.extension.clear();
  return input;
}

// The headers of a call under a lease. The job's request id connects the server's log lines with the worker's.
std::map<std::string, std::string> headers_of(const Lease& lease) {
  std::map<std::string, std::string> headers{{"Vacuform-Lease", lease.token}};
  if (!lease.request.empty()) headers["X-Request-Id"] = lease.request;
  return headers;
}

// Streams a GET into a file beside `target`, checks length and SHA-256, and renames it into place.
Result<void> fetch(Http& http, HttpRequest request, const std::filesystem::path& target, std::uint64_t bytes,
                   const std::string& sha256, const Going& going) {
  const auto part = std::filesystem::path(target).concat(".part");
  struct Closer {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  std::unique_ptr<std::FILE, Closer> file(std::fopen(part.c_str(), "wbe"));
  const Error unwritable{Code::unreadable, "the file cannot be written", target.string(),
                         "check the folder's permissions and the space on its disk"};
  if (!file) return tl::make_unexpected(unwritable);
  const auto give_up = [&](Error error) -> Result<void> {
    file.reset();
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return tl::make_unexpected(std::move(error));
  };
  Sha256 sha;
  std::uint64_t taken = 0;
  bool stored = true;
  request.sink = [&](std::span<const std::uint8_t> piece) {
    taken += piece.size();
    sha.add(piece);
    stored = std::fwrite(piece.data(), 1, piece.size(), file.get()) == piece.size();
    return stored && taken <= bytes;
  };
  if (going) request.going = [&](std::uint64_t, std::uint64_t) { return going(); };
  const auto response = good(http.send(request));
  if (!stored) return give_up(unwritable);
  const Error damaged{Code::unavailable, "the file arrived damaged", target.filename().string(), "try again"};
  if (taken > bytes) return give_up(damaged);
  if (!response) return give_up(response.error());
  if (std::fflush(file.get()) != 0) return give_up(unwritable);
  if (taken != bytes || sha.hex() != sha256) return give_up(damaged);
  file.reset();
  std::error_code ec;
  std::filesystem::rename(part, target, ec);
  if (ec) return give_up(unwritable);
  return {};
}

}  // namespace

Result<Client> Client::to(const std::string& server, const std::string& token) {
  VACUFORM_TRY(http, Http::to(server, token));
  return Client(std::move(http));
}

Result<RemoteJob> Client::submit(const JobRequest& job, const std::function<bool(double)>& uploaded) {
  HttpRequest request;
  request.method = "POST";
  request.path = "/api/v1/jobs";
  request.headers = {{"Idempotency-Key", random_key()}};
  request.form = {{"kind", {}, std::string(name(job.kind))}, {"settings", {}, job.settings}};
  for (const auto& [name, value] :
       {std::pair("from", job.from), std::pair("reference", job.reference),
        std::pair("rescan", std::string(job.rescan ? "true" : "")), std::pair("note", job.note)})
    if (!value.empty()) request.form.push_back({name, {}, value});
  for (const auto& [name, file] : job.files) {
    if (::access(file.c_str(), R_OK) != 0 || !std::filesystem::is_regular_file(file))
      return vacuform::fail(Code::unreadable, "the file cannot be read", file.string(),
                            "check its name and permissions");
    request.form.push_back({name, file, {}});
  }
  bool started = false;
  double fraction = 0;
  request.going = [&](std::uint64_t sent, std::uint64_t total) {
    started = started || sent > 0;
    fraction = total ? static_cast<double>(sent) / static_cast<double>(total) : 0.0;
    return uploaded(fraction);
  };
  // It is unknown whether an interrupted request was accepted; with the same key it may be sent again.
  constexpr int tries = 4;
  for (int attempt = 1;; ++attempt) {
    const auto response = good(http_.send(request));
    if (response) return job_from(*response);
    if (response.error().code != Code::unavailable || !started || attempt == tries)
      return tl::make_unexpected(response.error());
    for (int tenths = 0; tenths < 10 << attempt; ++tenths) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (!uploaded(fraction)) return vacuform::fail(Code::cancelled, "cancelled");
    }
  }
}

Result<RemoteJob> Client::job(const std::string& id, const Going& going) {
  if (!plain(id, 64))
    return vacuform::fail(Code::bad_usage, "not the id of a job: " + id, "--job",
                          "give the id as submit printed it");
  HttpRequest request;
  request.path = "/api/v1/jobs/" + id;
  request.limit = short_call;
  if (going) request.going = [&](std::uint64_t, std::uint64_t) { return going(); };
  VACUFORM_TRY(response, good(http_.send(request)));
  return job_from(response);
}

Result<void> Client::download(const std::string& id, const RemoteArtifact& artifact,
                              const std::filesystem::path& folder, const Going& going) {
  HttpRequest request;
  request.path = "/api/v1/jobs/" + id + "/artifacts/" + artifact.name;
  return fetch(http_, std::move(request), folder / artifact.name, artifact.bytes, artifact.sha256, going);
}

std::string Client::job_url(const std::string& id) const { return http_.url() + "/api/v1/jobs/" + id; }

Result<WorkerClient> WorkerClient::to(const std::string& server, const std::string& token) {
  VACUFORM_TRY(http, Http::to(server, token));
  return WorkerClient(std::move(http));
}

Result<std::optional<Lease>> WorkerClient::lease(const std::string& worker,
                                                 const std::vector<std::string>& sandbox) {
  HttpRequest request;
  request.method = "POST";
  request.path = "/api/v1/leases";
  request.headers = {{"Content-Type", "application/json"}};
  request.body = written(
      json{{"worker", worker}, {"sandbox", sandbox}, {"protocol", worker_protocol}, {"version", version}});
  request.limit = short_call;
  VACUFORM_TRY(response, good(http_.send(request)));
  if (response.status == 204) return std::nullopt;
  const json object = json::parse(response.body, nullptr, false);
  if (!object.is_object()) return tl::make_unexpected(not_vacuform("a lease is not a JSON object"));
  Lease lease;
  lease.job = text_of(object, "job");
  lease.token = text_of(object, "lease");
  if (!plain(lease.job, 64) || !plain(lease.token, 256))
    return tl::make_unexpected(not_vacuform("a lease without its job or token"));
  const auto job_kind = job_kind_from(text_of(object, "kind"));
  if (std::string id = text_of(object, "request"); is_request_id(id)) lease.request = std::move(id);
  lease.attempt = static_cast<int>(std::clamp(number_of(object, "attempt", 1), 1.0, 1e6));
  lease.seconds = std::chrono::seconds(
      static_cast<int>(std::clamp(number_of(object, "lease_seconds", 30), 1.0, 86400.0)));
  lease.heartbeat = std::chrono::seconds(
      static_cast<int>(std::clamp(number_of(object, "heartbeat_seconds", 10), 1.0, 3600.0)));
  const auto settings = object.find("settings");
  lease.settings = settings == object.end() || settings->is_null() ? "{}" : settings->dump();
  lease.reference = clean_reference(text_of(object, "reference")).value_or("");
  lease.cache = text_of(object, "cache");
  const auto inputs = object.find("inputs");
  const bool with_inputs = inputs != object.end() && inputs->is_object();
  if (with_inputs)
    for (const InputKind& kind : input_kinds)
      if (const auto from = inputs->find(kind.name); from != inputs->end() && from->is_object())
        lease.inputs.push_back(input_from(kind, *from));
  lease.kind = job_kind.value_or(JobKind::print);
  const auto of_job = settings_from_text(lease.settings);
  const bool prints_scan = of_job && of_job->pattern.source == PatternSource::scan;
  const bool whole = std::all_of(input_kinds.begin(), input_kinds.end(), [&](const InputKind& input) {
    return !needs(lease.kind, input, prints_scan) ||
           std::any_of(lease.inputs.begin(), lease.inputs.end(),
                       [&](const LeasedInput& leased) { return leased.name == input.name; });
  });
  // An input that this program does not know may change the result of the job.
  lease.understood = job_kind && whole && with_inputs && inputs->size() == lease.inputs.size();
  return lease;
}

Result<HttpResponse> WorkerClient::call(const Lease& lease, const std::string& method,
                                        const std::string& tail, const std::string& body,
                                        const Going& going) {
  HttpRequest request;
  request.method = method;
  request.path = "/api/v1/leases/" + lease.job + tail;
  request.headers = headers_of(lease);
  request.headers["Content-Type"] = "application/json";
  request.body = body;
  request.limit = short_call;
  if (going) request.going = [&](std::uint64_t, std::uint64_t) { return going(); };
  return good(http_.send(request));
}

Result<void> WorkerClient::download_input(const Lease& lease, const LeasedInput& input,
                                          const std::filesystem::path& file, const Going& going) {
  HttpRequest request;
  request.path = "/api/v1/leases/" + lease.job + "/inputs/" + input.name;
  request.headers = headers_of(lease);
  return fetch(http_, std::move(request), file, input.bytes, input.sha256, going);
}

Result<bool> WorkerClient::heartbeat(const Lease& lease, Stage stage, double progress, const Going& going) {
  const json body{{"stage", name(stage)}, {"progress", progress}};
  VACUFORM_TRY(response, call(lease, "POST", "/heartbeat", written(body), going));
  const json object = json::parse(response.body, nullptr, false);
  if (!object.is_object()) return tl::make_unexpected(not_vacuform("a heartbeat's answer"));
  return object.value("cancel", json(false)) == json(true);
}

Result<void> WorkerClient::upload(const Lease& lease, const std::string& artifact, int file,
                                  std::uint64_t bytes, const Going& going) {
  HttpRequest request;
  request.method = "PUT";
  request.path = "/api/v1/leases/" + lease.job + "/artifacts/" + artifact;
  request.headers = headers_of(lease);
  request.headers["Content-Type"] = "application/octet-stream";
  request.file = file;
  request.file_bytes = bytes;
  if (going) request.going = [&](std::uint64_t, std::uint64_t) { return going(); };
  VACUFORM_CHECK(good(http_.send(request)));
  return {};
}

Result<void> WorkerClient::complete(const Lease& lease, std::optional<int> serious_warnings) {
  json body = json::object();
  if (serious_warnings) body["serious_warnings"] = *serious_warnings;
  VACUFORM_CHECK(call(lease, "POST", "/complete", written(body)));
  return {};
}

Result<void> WorkerClient::log(const Lease& lease, std::size_t first, const std::vector<std::string>& lines,
                               const Going& going) {
  VACUFORM_CHECK(call(lease, "POST", "/log", written(json{{"first", first}, {"lines", lines}}), going));
  return {};
}

Result<void> WorkerClient::fail(const Lease& lease, const Error& error, Retry retry) {
  const json body{{"code", meaning(error.code).slug},
                  {"what", error.what},
                  {"where", error.where},
                  {"fix", error.fix},
                  {"proposals", proposals_json(error.proposals)},
                  {"retry", retry != Retry::never},
                  {"crashed", retry == Retry::after_crash}};
  VACUFORM_CHECK(call(lease, "POST", "/fail", written(body)));
  return {};
}

Result<void> WorkerClient::cancelled(const Lease& lease) {
  VACUFORM_CHECK(call(lease, "POST", "/cancelled", "{}"));
  return {};
}

Result<void> WorkerClient::release(const Lease& lease) {
  VACUFORM_CHECK(call(lease, "POST", "/release", "{}"));
  return {};
}

}  // namespace vacuform
