#include "server/http/connection.hpp"

#include <poll.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>

namespace vacuform::http {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

namespace {

bool named(std::string_view name, std::string_view wanted) {
  return name.size() == wanted.size() && strncasecmp(name.data(), wanted.data(), name.size()) == 0;
}

bool token(std::string_view text) {
  constexpr std::string_view others = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           others.find(c) != std::string_view::npos;
  });
}

// Of a request line: what HTTP has, whether an address answers to it or not (405).
bool known_method(std::string_view line) {
  const std::string_view method = line.substr(0, line.find(' '));
  for (const char* known : {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT"})
    if (method == known) return true;
  return !token(method) || line.find(" HTTP/") == std::string_view::npos;  // malformed, and refused as such
}

bool printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) >= 32 || c == '\t'; });
}

}  // namespace

Connection::Connection(int socket, const Limits& limits, const std::atomic<bool>& stopping)
    : socket_(socket), limits_(limits), stopping_(stopping) {}

Connection::~Connection() { ::close(socket_); }

Connection::Wait Connection::wait_for(short events, Instant deadline) const {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - steady_clock::now());
    if (left <= 0ms) return Wait::late;
    if (stopping_) return Wait::gone;
    pollfd watched{socket_, events, 0};
    const int n =
        ::poll(&watched, 1, static_cast<int>(std::min(left, std::chrono::milliseconds(500)).count()));
    if (n > 0) return (watched.revents & (events | POLLHUP)) != 0 ? Wait::ready : Wait::gone;
    if (n < 0 && errno != EINTR) return Wait::gone;
  }
}

void Connection::refuse(int status, std::string what, std::string mend) {
  Code code = Code::bad_usage;
  if (status == 413 || status == 414 || status == 431) code = Code::too_large;
  if (status == 408) code = Code::out_of_time;
  refusal_ = Refusal{status, {code, std::move(what), "request head", std::move(mend)}};
}

bool Connection::read_head() {
  const Instant deadline = steady_clock::now() + limits_.head_time;
  std::string text;
  std::array<char, 4096> piece;
  for (;;) {
    const std::size_t searched = text.size() < 3 ? 0 : text.size() - 3;
    const Wait wait = wait_for(POLLIN, deadline);
    if (wait == Wait::gone || (wait == Wait::late && text.empty())) return false;
    if (wait == Wait::late) return refuse(408, "the head of the request took too long", "try again"), true;
    const ssize_t n = ::recv(socket_, piece.data(), piece.size(), 0);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0) return false;
    text.append(piece.data(), static_cast<std::size_t>(n));
    const std::size_t end = text.find("\r\n\r\n", searched);
    if (std::min(end, text.size()) > limits_.head_bytes)
      return refuse(431,
                    "the head of the request is longer than " + std::to_string(limits_.head_bytes) + " bytes",
                    "send fewer or shorter header lines"),
             true;
    if (end == std::string::npos) continue;
    early_ = text.substr(end + 4);
    parse_head(std::string_view(text).substr(0, end + 2));
    if (early_.size() > head_.content_length) early_.resize(head_.content_length);
    body_started_ = steady_clock::now();
    return true;
  }
}

void Connection::parse_head(std::string_view text) {
  const std::size_t first = text.find("\r\n");
  head_.request_line = text.substr(0, first);
  if (!printable(head_.request_line) || head_.request_line.find('\t') != std::string::npos)
    return refuse(400, "the request line is malformed", "send HTTP/1.1");
  if (head_.request_line.size() > 4096) return refuse(414, "the address is too long", "send a shorter one");
  text.remove_prefix(first + 2);
  int hosts = 0, lengths = 0;
  while (!text.empty()) {
    const std::size_t end = text.find("\r\n");
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 2);
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || !token(line.substr(0, colon)) || !printable(line))
      return refuse(400, "a header line is malformed", "send name: value");
    std::string_view name = line.substr(0, colon), value = line.substr(colon + 1);
    while (!value.empty() && (value.front() == ' ' || value.front() == '\t')) value.remove_prefix(1);
    while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.remove_suffix(1);
    if (head_.headers.size() >= limits_.head_lines)
      return refuse(431, "the request has more than " + std::to_string(limits_.head_lines) + " header lines",
                    "send fewer");
    if (named(name, "Transfer-Encoding"))
      return refuse(411, "a body without Content-Length is not accepted",
                    "send Content-Length in place of chunks");
    if (named(name, "Content-Encoding") && !named(value, "identity"))
      return refuse(501, "an encoded body is not accepted",
                    "send the body as it is, without Content-Encoding");
    if (named(name, "Content-Length")) {
      const auto [stop, error] =
          std::from_chars(value.data(), value.data() + value.size(), head_.content_length);
      if (++lengths > 1 || value.empty() || error != std::errc() || stop != value.data() + value.size()) {
        head_.content_length = 0;
        return refuse(400, "Content-Length is not one whole number", "send the number of bytes of the body");
      }
    }
    if (named(name, "Host") && ++hosts > 1) return refuse(400, "there is more than one Host", "send one");
    if (named(name, "Expect")) {
      if (!named(value, "100-continue"))
        return refuse(417, "an unknown expectation", "send no Expect header");
      continue_due_ = true;
    }
    head_.headers.push_back({std::string(name), std::string(value)});
  }
  if (hosts == 0) return refuse(400, "there is no Host", "send HTTP/1.1 with a Host");
  if (!known_method(head_.request_line))
    refuse(501, "there is no such method here", "send GET, HEAD, POST, PUT, PATCH, DELETE or OPTIONS");
}

Result<std::size_t> Connection::read(std::span<char> into) {
  const std::uint64_t left = head_.content_length - body_read_;
  const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(into.size(), left));
  if (wanted == 0) return 0;
  if (!early_.empty()) {
    const std::size_t n = std::min(wanted, early_.size());
    std::copy_n(early_.begin(), n, into.begin());
    early_.erase(0, n);
    body_read_ += n;
    return n;
  }
  if (continue_due_) {
    continue_due_ = false;
    write("HTTP/1.1 100 Continue\r\n\r\n");
  }
  const Instant now = steady_clock::now();
  const Instant slowest =
      body_started_ + limits_.wait + std::chrono::seconds(body_read_ / limits_.slowest_body + 1);
  for (;;) {
    const Wait wait = wait_for(POLLIN, std::min(now + limits_.wait, slowest));
    if (wait == Wait::late)
      return fail(Code::out_of_time, "the body of the request came too slowly", {}, "try again");
    const ssize_t n = wait == Wait::gone ? 0 : ::recv(socket_, into.data(), wanted, 0);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0)
      return fail(Code::bad_usage,
                  "the body of the request ended after " + std::to_string(body_read_) + " of " +
                      std::to_string(head_.content_length) + " bytes",
                  {}, "send it again");
    body_read_ += static_cast<std::uint64_t>(n);
    return static_cast<std::size_t>(n);
  }
}

bool Connection::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
    } else if (n < 0 && errno == EAGAIN) {
      if (wait_for(POLLOUT, steady_clock::now() + limits_.wait) != Wait::ready) return false;
    } else if (n == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

bool Connection::gone() const {
  pollfd watched{socket_, POLLRDHUP, 0};
  return ::poll(&watched, 1, 0) > 0;
}

void Connection::finish() {
  ::shutdown(socket_, SHUT_WR);
  const bool all_read = !refusal_ && body_read_ == head_.content_length;
  if (all_read || (refusal_ && refusal_->status == 408)) return;
  // Closing with unread bytes would reset the connection and destroy the answer on its way.
  const Instant deadline = steady_clock::now() + 2s;
  std::array<char, 16384> piece;
  while (wait_for(POLLIN, deadline) == Wait::ready) {
    const ssize_t n = ::recv(socket_, piece.data(), piece.size(), MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN)) return;
  }
}

}  // namespace vacuform::http
