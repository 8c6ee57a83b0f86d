// Who reaches a route: the callers with a scope, or everybody for a reason that stands in one table.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "server/jobs/service.hpp"
#include "server/messages/router.hpp"

namespace vacuform {

// Adds a route that only a caller with this scope reaches, and whose body has at most so many bytes. The token is checked
// before the body is waited for. Route::admits is the name of the scope.
using GuardedHandler = std::function<Result<http::Response>(Service&, http::Request&, const Caller&)>;
void add_guarded(http::Router& router, Service& service, Scope scope, std::string method, std::string pattern,
                 GuardedHandler handler, std::uint64_t most_body = http::small_body);

// Adds a route that answers without a token. Route::admits is "everybody: " and the reason. Throws std::logic_error
// unless public_routes() lists it.
void add_public(http::Router& router, std::string method, std::string pattern, http::Handler handler,
                std::uint64_t most_body = http::small_body);

}  // namespace vacuform
