#include "server/problem.hpp"

#include <nlohmann/json.hpp>

namespace vacuform {

using nlohmann::ordered_json;

ordered_json problem_json(const Error& error, int status) {
  const CodeMeaning code = meaning(error.code);
  return {{"type", "/problems/" + std::string(code.slug)},
          {"title", code.title},
          {"status", status != 0 ? status : code.http_status},
          {"detail", error.text()},
          {"what", error.what},
          {"where", error.where},
          {"mend", error.mend}};
}

http::Response problem_response(const Error& error, int status) {
  const int given = status != 0 ? status : meaning(error.code).http_status;
  http::Response response =
      http::text_response("application/problem+json", dump(problem_json(error, given)), given);
  response.set("Cache-Control", "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  if (given == 503) response.set("Retry-After", "5");
  if (given == 429) response.set("Retry-After", "60");
  if (error.code == Code::unauthorized) response.set("WWW-Authenticate", "Bearer realm=\"vacuform\"");
  if (error.code == Code::forbidden)
    response.set("WWW-Authenticate", "Bearer realm=\"vacuform\", error=\"insufficient_scope\"");
  return response;
}

std::string dump(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

http::Response json_response(const ordered_json& json, int status) {
  http::Response response = http::text_response("application/json", dump(json), status);
  response.set("Cache-Control", "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

}  // namespace vacuform
