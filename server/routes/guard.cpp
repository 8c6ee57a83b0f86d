#include "server/routes/guard.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace vacuform {

using http::Request;

namespace {

struct PublicRoute {
  std::string_view method, pattern, reason;
};

// Every route that asks for no token.
constexpr PublicRoute public_routes[] = {
    {"GET", "/sign-in?link", "the way to a session"},
    {"POST", "/sign-in", "the token or the code of a link is in its body"},
    {"POST", "/sign-out", "ends the session of the request, if there is one"},
    {"GET", "/style.css", "the sign-in page needs it; part of the program"},
    {"GET", "/job.js", "part of the program"},
    {"GET", "/app/{name}", "part of the program"},
    {"GET", "/sample/head.stl", "part of the program"},
    {"GET", "/sample/pattern.svg", "part of the program"},
    {"GET", "/problems/", "part of the program"},
    {"GET", "/problems/{slug}", "part of the program"},
    {"GET", "/api/v1/openapi.yaml", "part of the program"},
    {"GET", "/api/v1/settings-schema", "part of the program"},
    {"OPTIONS", "/api/v1/uploads", "says what this server knows of tus"},
    {"OPTIONS", "/api/v1/uploads/{id}", "says what this server knows of tus"},
    {"GET", "/healthz", "says that the process answers"},
    {"GET", "/readyz", "on the listener for the operator's machines alone"},
    {"GET", "/metrics", "on the listener for the operator's machines alone; counts without ids or names"},
};

}  // namespace

void add_guarded(http::Router& router, Service& service, Scope scope, std::string method, std::string pattern,
                 GuardedHandler handler, std::uint64_t most_body) {
  http::Route route{
      std::move(method), std::move(pattern),
      [s = &service, scope, handler = std::make_shared<const GuardedHandler>(std::move(handler))](
          const Request& request) -> Result<http::Admitted> {
        VACUFORM_TRY(caller, s->access.check(request, scope));
        std::string client = caller.owner;
        return http::Admitted{std::move(client), [s, handler, caller = std::move(caller)](Request& r) {
                                return (*handler)(*s, r, caller);
                              }};
      },
      most_body};
  route.admits = name(scope);
  router.add(std::move(route));
}

void add_public(http::Router& router, std::string method, std::string pattern, http::Handler handler,
                std::uint64_t most_body) {
  const auto listed =
      std::find_if(std::begin(public_routes), std::end(public_routes),
                   [&](const auto& route) { return route.method == method && route.pattern == pattern; });
  if (listed == std::end(public_routes))
    throw std::logic_error("not a public route: " + method + " " + pattern);
  http::Route route{std::move(method), std::move(pattern), http::everybody(std::move(handler)), most_body};
  route.admits = "everybody: " + std::string(listed->reason);
  router.add(std::move(route));
}

}  // namespace vacuform
