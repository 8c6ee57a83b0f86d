#include "server/messages/problem.hpp"

#include <nlohmann/json.hpp>

#include "api/base/strict_json.hpp"
#include "api/base/text.hpp"
#include "api/base/utf8.hpp"
#include "api/problem.hpp"

namespace vacuform {

using nlohmann::ordered_json;

ordered_json problem_json(const Error& error, int status) {
  const CodeMeaning code = meaning(error.code);
  return {{"type", "/problems/" + std::string(code.slug)},
          {"title", code.title},
          {"status", status != 0 ? status : code.http_status},
          {"detail", error.text()},
          {"what", printable(error.what)},
          {"where", printable(error.where)},
          {"fix", printable(error.fix)},
          {"proposals", proposals_json(error.proposals)}};
}

http::Response problem_response(const Error& error, int status) {
  const int given = status != 0 ? status : meaning(error.code).http_status;
  http::Response response =
      http::text_response("application/problem+json", dump(problem_json(error, given)), given);
  response.set("Cache-Control", "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  set_retry_after(response);
  if (error.code == Code::unauthorized) response.set("WWW-Authenticate", "Bearer realm=\"vacuform\"");
  if (error.code == Code::forbidden)
    response.set("WWW-Authenticate", "Bearer realm=\"vacuform\", error=\"insufficient_scope\"");
  return response;
}

void set_retry_after(http::Response& response) {
  if (response.status == 503) response.set("Retry-After", "5");
  if (response.status == 429 || response.status == 507) response.set("Retry-After", "60");
}

void set_retry_after(http::Response& response, std::int64_t seconds) {
  std::erase_if(response.headers, [](const http::Header& header) { return header.name == "Retry-After"; });
  response.set("Retry-After", std::to_string(seconds));
}

std::string dump(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Result<std::string> read_json_text(http::Request& request, std::uint64_t limit) {
  const std::string_view stated = request.header("Content-Type");
  const std::string_view media = stated.substr(0, stated.find_first_of("; "));
  if (request.content_length > 0 && !equal_ignoring_case(media, "application/json"))
    return fail(Code::unsupported_format, "the request does not say that its body is JSON", "Content-Type",
                "send Content-Type: application/json");
  return http::read_text(request, limit);
}

Result<nlohmann::json> read_object(http::Request& request, std::uint64_t limit) {
  VACUFORM_TRY(text, read_json_text(request, limit));
  if (text.empty()) return nlohmann::json::object();
  auto object = strict_json<nlohmann::json>(text);
  if (!object) {
    object.error().where = "request body";
    return object;
  }
  if (!object->is_object())
    return fail(Code::bad_usage, "the body is not a JSON object", "request body", "see /api/v1/openapi.yaml");
  return object;
}

http::Response json_response(const ordered_json& json, int status) {
  return json_text_response(dump(json), status);
}

http::Response json_text_response(std::string text, int status) {
  http::Response response = http::text_response("application/json", std::move(text), status);
  response.set("Cache-Control", "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

}  // namespace vacuform
