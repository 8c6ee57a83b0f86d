// Whom a server on loopback, or behind a front, may believe. A web page anywhere can make a browser send requests to 127.0.0.1:
// by a name that it points there (DNS rebinding), which Host gives away, or by a form of its own, which
// Origin gives away.
#pragma once

#include <optional>

#include "server/http/message.hpp"

namespace vacuform::http {

// "127.0.0.1:8080", "localhost", "[::1]:80": a loopback name with or without a port.
bool is_loopback_host(std::string_view host);

// Whether the request names the front as its host. `front_host` is in lower case; empty: there is none.
bool through_front(const Request& request, std::string_view front_host);

// Whether the local address of a connection is on loopback.
bool is_loopback_socket(int socket);

// Refuses a request that came beyond loopback and does not carry the front's name and its X-Forwarded-Proto: https (421).
// Refuses a Host that is neither loopback nor `front_host` (421), and an unsafe request whose Origin is not that Host under
// the scheme by which it is reached: https through the front, http on loopback (403). Programs send no Origin and pass.
std::optional<Refusal> check_origin(const Request& request, std::string_view front_host = {});

}  // namespace vacuform::http
