// Which requests a server on loopback, or behind a front, may trust. Any web page can make a browser send requests to
// 127.0.0.1: with a name that resolves there (DNS rebinding), which Host reveals, or with an HTML form, which Origin
// reveals.
#pragma once

#include <optional>

#include "server/messages/message.hpp"

namespace vacuform::http {

// "127.0.0.1:8080", "localhost", "[::1]:80": a loopback name with or without a port.
bool is_loopback_host(std::string_view host);

// Whether the request names the front as its host. `front_host` is in lower case; empty: no front.
bool through_front(const Request& request, std::string_view front_host);

// Whether the local address of a connection is on loopback.
bool is_loopback_socket(int socket);

// Refuses a request that arrived at an address not on loopback without the front's name and its X-Forwarded-Proto:
// https (421). Refuses a Host that is neither loopback nor `front_host` (421), and an unsafe request whose Origin is
// not that Host with the scheme in use: https through the front, http on loopback (403). Programs send no Origin and
// pass.
std::optional<Refusal> check_origin(const Request& request, std::string_view front_host = {});

}  // namespace vacuform::http
