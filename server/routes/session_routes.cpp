// Who is signed in, so that a page can show it and warn before the session ends.
#include <nlohmann/json.hpp>

#include "server/access/token_json.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

ordered_json rfc3339_or_null(const std::optional<Millis>& time) {
  return time ? ordered_json(rfc3339(*time)) : ordered_json();
}

}  // namespace

void add_session_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::read, "GET", "/api/v1/session",
              [](Service&, Request&, const Caller& caller) -> Result<Response> {
                return json_response({{"owner", caller.owner},
                                      {"token", caller.token},
                                      {"scopes", scopes_json(caller.scopes)},
                                      {"expires", rfc3339_or_null(caller.expires)},
                                      {"session_ends", rfc3339_or_null(caller.session_ends)}});
              });
}

}  // namespace vacuform
