#include "server/messages/origin.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>

#include "api/base/text.hpp"

namespace vacuform::http {

bool is_loopback_host(std::string_view host) {
  std::string_view name = host, port;
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return false;
    name = host.substr(1, end - 1);
    port = host.substr(end + 1);
  } else if (const std::size_t colon = host.find(':'); colon != std::string_view::npos) {
    name = host.substr(0, colon);
    port = host.substr(colon);
  }
  if (!port.empty() &&
      (port.front() != ':' || port.size() > 6 ||
       !std::all_of(port.begin() + 1, port.end(), [](char c) { return c >= '0' && c <= '9'; })))
    return false;
  in_addr four{};
  const std::string text(name);
  if (inet_pton(AF_INET, text.c_str(), &four) == 1) return (ntohl(four.s_addr) >> 24) == 127;
  return equal_ignoring_case(name, "localhost") || text == "::1";
}

bool is_loopback_socket(int socket) {
  sockaddr_storage address{};
  socklen_t bytes = sizeof address;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &bytes) != 0) return false;
  if (address.ss_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24 == 127;
  if (address.ss_family != AF_INET6) return false;
  const in6_addr& six = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&six) || (IN6_IS_ADDR_V4MAPPED(&six) && six.s6_addr[12] == 127);
}

bool through_front(const Request& request, std::string_view front_host) {
  const std::string_view host = request.header("Host");
  return !front_host.empty() && equal_ignoring_case(host, front_host);
}

std::optional<Refusal> check_origin(const Request& request, std::string_view front_host) {
  const std::string_view host = request.header("Host");
  const bool by_front = through_front(request, front_host);
  if (request.beyond_loopback && !(by_front && request.header("X-Forwarded-Proto") == "https"))
    return Refusal{421,
                   {Code::bad_usage, "beyond loopback this server answers through its TLS front only", "Host",
                    front_host.empty() ? "address it as 127.0.0.1 or localhost, on its own machine"
                                       : "address it as https://" + std::string(front_host)}};
  if (!is_loopback_host(host) && !by_front)
    return Refusal{421,
                   {Code::bad_usage,
                    front_host.empty() ? "this server answers on loopback only"
                                       : "this server answers on loopback and under its front's name only",
                    "Host",
                    front_host.empty() ? "address it as 127.0.0.1 or localhost"
                                       : "address it as https://" + std::string(front_host)}};
  if (request.method == "GET" || request.method == "HEAD" || request.method == "OPTIONS") return std::nullopt;
  const std::string_view origin = request.header("Origin");
  if (!origin.empty() && origin != (by_front ? "https://" : "http://") + std::string(host))
    return Refusal{403,
                   {Code::bad_usage, "the request comes from a page of another origin", "Origin",
                    "use the pages of this server"}};
  return std::nullopt;
}

}  // namespace vacuform::http
