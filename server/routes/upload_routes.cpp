// Resumable uploads: tus 1.0.0 (https://tus.io/protocols/resumable-upload) with creation, creation-with-upload,
// checksum, expiration and termination. A complete upload becomes a scan or an input of jobs by its id.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

#include "api/base/base64.hpp"
#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "server/messages/digest.hpp"
#include "server/messages/multipart.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

constexpr const char* version = "1.0.0";
constexpr const char* extensions = "creation,creation-with-upload,checksum,expiration,termination";
constexpr const char* chunk_type = "application/offset+octet-stream";
constexpr int checksum_mismatch = 460;  // of tus

// "Sun, 06 Nov 1994 08:49:37 GMT" (RFC 9110).
std::string http_date(Millis time) {
  constexpr const char* days[] = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr const char* months[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                    "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t seconds = time / 1000;
  std::tm t{};
  gmtime_r(&seconds, &t);
  char text[64];
  std::snprintf(text, sizeof text, "%s, %02d %s %04d %02d:%02d:%02d GMT", days[t.tm_wday], t.tm_mday,
                months[t.tm_mon], t.tm_year + 1900, t.tm_hour, t.tm_min, t.tm_sec);
  return text;
}

Result<std::uint64_t> number_in(const Request& request, const char* name) {
  const std::string_view text = request.header(name);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size())
    return fail(Code::bad_usage, "there is no such header with a whole number", name, "see tus 1.0.0");
  return number;
}

struct Metadata {
  std::string input = "scan", extension;
};

// "filename aGVhZC5zdGw=,input c2Nhbg==": only the extension of the name is stored, other keys are ignored.
Result<Metadata> metadata_of(std::string_view text) {
  Metadata metadata;
  while (!text.empty()) {
    const std::string_view pair = text.substr(0, text.find(','));
    text.remove_prefix(std::min(pair.size() + 1, text.size()));
    const std::size_t space = pair.find(' ');
    const std::string_view key = pair.substr(0, space);
    const auto value = from_base64(space == std::string_view::npos ? "" : pair.substr(space + 1));
    if (!value)
      return fail(Code::bad_usage, "a value is not base 64", "Upload-Metadata",
                  "send key BASE64, key BASE64");
    if (key == "filename") metadata.extension = http::safe_extension(*value);
    if (key == "input") metadata.input = *value;
  }
  return metadata;
}

// Extensions of tus that change what a request means, and are not there.
Result<void> refuse_unknown_extensions(const Request& request) {
  if (!request.has("Upload-Concat")) return {};
  return fail(Code::bad_usage, "uploads are not put together from others", "Upload-Concat",
              "send the whole file as one upload");
}

ordered_json upload_json(const StoredUpload& upload, std::uint64_t offset) {
  return {{"id", upload.id},
          {"input", upload.input},
          {"extension", upload.extension},
          {"length", upload.length},
          {"offset", offset},
          {"sha256", upload.blob ? ordered_json(upload.blob->sha256) : ordered_json()},
          {"created", rfc3339(upload.created)},
          {"expires", rfc3339(upload.expires)}};
}

void set_place(Response& response, const StoredUpload& upload, std::uint64_t offset) {
  response.set("Upload-Offset", std::to_string(offset));
  response.set("Upload-Expires", http_date(upload.expires));
  response.set("Cache-Control", "no-store");
}

// The body of a request, checked against its Upload-Checksum; null if it has none. Errors: bad_usage.
Result<std::unique_ptr<http::Body>> checked(const Request& request) {
  const std::string_view stated = request.header("Upload-Checksum");
  if (stated.empty()) return std::unique_ptr<http::Body>();
  const std::size_t space = stated.find(' ');
  const std::string_view name = stated.substr(0, space);
  const auto kind = name == "sha1" ? http::Algorithm::sha1 : http::Algorithm::sha256;
  const auto digest = space == std::string_view::npos
                          ? std::nullopt
                          : http::digest_from_base64(stated.substr(space + 1), kind);
  if ((name != "sha1" && name != "sha256") || !digest)
    return fail(Code::bad_usage, "not a checksum that is known here", "Upload-Checksum",
                "send sha256 or sha1 and the base 64 of the digest");
  return http::checked_body(*request.body, *digest, kind);
}

// Appends the bytes of a request to an upload.
Result<std::uint64_t> take(Service& service, Request& request, const StoredUpload& upload,
                           std::uint64_t offset) {
  VACUFORM_TRY(body, checked(request));
  const bool whole = body || !request.header("Content-Digest").empty();
  if (body) request.body = body.get();
  return service.uploads.append(upload, offset, request, whole);
}

Result<Response> create(Service& service, Request& request, const Caller& caller) {
  if (!request.header("Upload-Defer-Length").empty())
    return fail(Code::bad_usage, "the length must be known at the beginning", "Upload-Defer-Length",
                "send Upload-Length");
  VACUFORM_CHECK(refuse_unknown_extensions(request));
  VACUFORM_TRY(length, number_in(request, "Upload-Length"));
  VACUFORM_TRY(metadata, metadata_of(request.header("Upload-Metadata")));
  const InputKind* kind = input_kind(metadata.input);
  if (!kind)
    return fail(
        Code::bad_usage, "there is no such input", "Upload-Metadata",
        "give the key input as scan, pattern, temperature, weights or icc, or leave it out for a scan");
  VACUFORM_TRY(upload, service.uploads.begin(caller.owner, *kind, metadata.extension, length));
  log_event("upload-started", {{"upload", upload.id}, {"bytes", length}, {"token", caller.token}});
  std::uint64_t offset = 0;
  if (request.header("Content-Type") == chunk_type && request.content_length > 0) {
    // Bytes that were lost are sent again with PATCH: the upload exists in any case.
    if (const auto taken = take(service, request, upload, 0)) offset = *taken;
  }
  Response response = json_response(upload_json(upload, offset), 201);
  response.set("Location", "/api/v1/uploads/" + upload.id);
  response.set("Upload-Offset", std::to_string(offset));
  response.set("Upload-Expires", http_date(upload.expires));
  return response;
}

Result<Response> show(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(upload, upload_for(service, request.at("id"), caller));
  VACUFORM_TRY(offset, service.uploads.offset(upload));
  VACUFORM_TRY(now, service.store.find_upload(upload.id));
  Response response = json_response(upload_json(now, offset));
  response.set("Upload-Length", std::to_string(upload.length));
  response.set("Upload-Offset", std::to_string(offset));
  response.set("Upload-Expires", http_date(upload.expires));
  return response;
}

Result<Response> append(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(upload, upload_for(service, request.at("id"), caller));
  if (request.header("Content-Type") != chunk_type)
    return fail(Code::unsupported_format, "the body is not a piece of an upload", "Content-Type",
                std::string("send ") + chunk_type);
  VACUFORM_TRY(at, number_in(request, "Upload-Offset"));
  VACUFORM_TRY(offset, take(service, request, upload, at));
  if (offset == upload.length) log_event("upload-whole", {{"upload", upload.id}, {"token", caller.token}});
  Response response = no_content();
  set_place(response, upload, offset);
  return response;
}

Result<Response> terminate(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(upload, upload_for(service, request.at("id"), caller));
  VACUFORM_CHECK(service.uploads.remove(upload.id));
  log_event("upload-ended", {{"upload", upload.id}, {"token", caller.token}});
  return no_content();
}

// For clients behind a proxy that only supports GET and POST.
Result<Response> overridden(Service& service, Request& request, const Caller& caller) {
  const std::string_view method = request.header("X-HTTP-Method-Override");
  if (method == "PATCH") return append(service, request, caller);
  if (method == "DELETE") return terminate(service, request, caller);
  if (method == "HEAD") return show(service, request, caller);
  return problem_response({Code::bad_usage, "this address does not answer to POST", "X-HTTP-Method-Override",
                           "send PATCH, HEAD or DELETE, there or as the method"},
                          405);
}

// Every route supports one version of tus, in its refusals too.
GuardedHandler speaking_tus(Result<Response> (*handler)(Service&, Request&, const Caller&)) {
  return [handler](Service& service, Request& request, const Caller& caller) -> Result<Response> {
    Result<Response> result = Response();
    const std::string_view spoken = request.header("Tus-Resumable");
    if (spoken != version && request.method != "GET") {
      result = problem_response({Code::bad_usage, "the client does not speak tus 1.0.0", "Tus-Resumable",
                                 "send Tus-Resumable: 1.0.0"},
                                412);
      result->set("Tus-Version", version);
    } else {
      result = handler(service, request, caller);
    }
    if (!result) {
      const Error& error = result.error();
      result = problem_response(error, error.code == Code::wrong_digest ? checksum_mismatch : 0);
    }
    result->set("Tus-Resumable", version);
    return result;
  };
}

Result<Response> shown(Service& service, Request& request, const Caller& caller) {
  return show(service, request, caller);
}
Result<Response> ended(Service& service, Request& request, const Caller& caller) {
  return terminate(service, request, caller);
}

std::uint64_t largest_upload() {
  std::uint64_t most = 0;
  for (const InputKind& kind : input_kinds) most = std::max(most, kind.most_bytes);
  return most;
}

Result<Response> options(Request&) {
  Response response = no_content();
  response.set("Tus-Resumable", version);
  response.set("Tus-Version", version);
  response.set("Tus-Extension", extensions);
  response.set("Tus-Max-Size", std::to_string(largest_upload()));
  response.set("Tus-Checksum-Algorithm", "sha1,sha256");
  return response;
}

}  // namespace

void add_upload_routes(http::Router& router, Service& service) {
  const std::string all = "/api/v1/uploads", one = all + "/{id}";
  add_public(router, "OPTIONS", all, options);
  add_public(router, "OPTIONS", one, options);
  add_guarded(router, service, Scope::submit, "POST", all, speaking_tus(create), largest_upload());
  add_guarded(router, service, Scope::submit, "GET", one, speaking_tus(shown));
  add_guarded(router, service, Scope::submit, "PATCH", one, speaking_tus(append), largest_upload());
  add_guarded(router, service, Scope::submit, "DELETE", one, speaking_tus(ended));
  add_guarded(router, service, Scope::submit, "POST", one, speaking_tus(overridden), largest_upload());
}

}  // namespace vacuform
