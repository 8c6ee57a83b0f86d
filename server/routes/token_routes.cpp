// Tokens through the API, for callers with the scope admin.
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/access/token_json.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

constexpr std::uint64_t largest_token_message = 4 << 10;

Result<Response> create_token(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(body, read_object(request, largest_token_message));
  VACUFORM_TRY(wanted, new_token_from(body, wall_clock()));
  VACUFORM_TRY(made, make_token(service.store, wanted));
  log_event("token-created",
            {{"token", made.token.id}, {"scopes", made.token.scopes.text()}, {"by", caller.token}});
  ordered_json answer = token_json(made.token);
  answer["token"] = made.text;
  return json_response(answer, 201);
}

Result<Response> list_tokens(Service& service, Request&, const Caller&) {
  VACUFORM_TRY(tokens, service.store.tokens());
  ordered_json list = ordered_json::array();
  for (const Token& token : tokens) list.push_back(token_json(token));
  return json_response({{"tokens", list}});
}

// A link that a person opens in place of showing the token.
Result<Response> create_link(Service& service, Request& request, const Caller& caller) {
  const std::string& id = request.at("id");
  VACUFORM_TRY(link, service.access.make_link(id));
  log_event("sign-in-link-created", {{"token", id}, {"by", caller.token}});
  return json_response({{"path", "/sign-in?link=" + link.code}, {"expires", rfc3339(link.expires)}}, 201);
}

Result<Response> revoke_token(Service& service, Request& request, const Caller& caller) {
  VACUFORM_CHECK(service.store.revoke_token(request.at("id")));
  log_event("token-revoked", {{"token", request.at("id")}, {"by", caller.token}});
  return no_content();
}

}  // namespace

void add_token_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::admin, "POST", "/api/v1/tokens", create_token);
  add_guarded(router, service, Scope::admin, "GET", "/api/v1/tokens", list_tokens);
  add_guarded(router, service, Scope::admin, "POST", "/api/v1/tokens/{id}/link", create_link);
  add_guarded(router, service, Scope::admin, "DELETE", "/api/v1/tokens/{id}", revoke_token);
}

}  // namespace vacuform
