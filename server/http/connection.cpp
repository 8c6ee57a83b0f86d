#include "server/http/connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace vacuform::http {

using namespace std::chrono_literals;

namespace {

constexpr auto look = 500ms;  // at the server, which may be stopping
constexpr auto linger_time = 2s;
constexpr auto grace = 1s;  // before a body or an answer may count as slow

}  // namespace

Connection::Connection(int socket, const Limits& limits, const std::atomic<bool>& stopping)
    : socket_(socket), limits_(limits), stopping_(stopping) {}

Connection::~Connection() { ::close(socket_); }

void Connection::enter(Phase phase) {
  phase_ = phase;
  since_ = Clock::now();
  moved_ = 0;
}

void Connection::evict() {
  evicted_ = true;
  ::shutdown(socket_, SHUT_RDWR);
}

std::optional<Connection::Rank> Connection::rank(Clock::time_point now) const {
  if (evicted_) return std::nullopt;
  const double seconds = std::chrono::duration<double>(now - since_.load()).count();
  switch (phase_.load()) {
    case Phase::linger:
      return Rank{0, -seconds};
    case Phase::head:
      return Rank{1, -seconds};
    case Phase::body:
    case Phase::answer:
      if (seconds < std::chrono::duration<double>(grace).count()) return std::nullopt;
      return Rank{2, static_cast<double>(moved_) / seconds};
    case Phase::work:
      return std::nullopt;
  }
  return std::nullopt;
}

Connection::Wait Connection::wait_for(short events, Clock::time_point deadline) const {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (stopping_ || evicted_) return Wait::gone;
    if (left <= 0ms) return Wait::late;
    pollfd watched{socket_, events, 0};
    const int n =
        ::poll(&watched, 1, static_cast<int>(std::min<std::chrono::milliseconds>(left, look).count()));
    if (n > 0) return (watched.revents & (events | POLLHUP)) != 0 ? Wait::ready : Wait::gone;
    if (n < 0 && errno != EINTR) return Wait::gone;
  }
}

// Counts only the time spent waiting for the client, not the time of the disk behind the route.
Connection::Wait Connection::wait_for(short events, Pace& pace) const {
  const double least =
      static_cast<double>(limits_.slowest_body) * std::chrono::duration<double>(limits_.wait).count();
  for (;;) {
    const auto started = Clock::now();
    const Wait wait = wait_for(events, started + (limits_.wait - pace.waited));
    pace.waited += Clock::now() - started;
    if (wait == Wait::gone || pace.waited < limits_.wait) return wait;
    if (static_cast<double>(pace.bytes) < least) return Wait::late;
    pace = {};
    if (wait == Wait::ready) return wait;
  }
}

std::optional<tl::expected<Head, Refusal>> Connection::read_head() {
  const auto refuse = [](int status, Code code, std::string what, std::string fix) {
    return tl::make_unexpected(Refusal{status, {code, std::move(what), "request head", std::move(fix)}});
  };
  const auto deadline = Clock::now() + limits_.head_time;
  std::array<char, 8192> piece;
  for (std::size_t searched = 0;;) {
    const std::size_t end = in_.find("\r\n\r\n", searched < 3 ? 0 : searched - 3);
    searched = in_.size();
    if (std::min(end, in_.size()) > limits_.head_bytes)
      return refuse(431, Code::too_large,
                    "the head of the request is longer than " + std::to_string(limits_.head_bytes) + " bytes",
                    "send fewer or shorter header lines");
    if (end != std::string::npos) {
      auto head = parse_head(std::string_view(in_).substr(0, end + 2), limits_);
      in_.erase(0, end + 4);
      length_ = head ? head->content_length : 0;
      continue_due_ = head && head->expects_continue;
      return head;
    }
    const Wait wait = wait_for(POLLIN, deadline);
    if (wait == Wait::gone || (wait == Wait::late && in_.empty())) return std::nullopt;
    if (wait == Wait::late)
      return refuse(408, Code::out_of_time, "the head of the request took too long", "try again");
    const ssize_t n = ::recv(socket_, piece.data(), piece.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n <= 0) return std::nullopt;
    in_.append(piece.data(), static_cast<std::size_t>(n));
  }
}

ssize_t Connection::fail_with(int status, Error error) {
  trouble_ = Refusal{status, std::move(error)};
  return -1;
}

ssize_t Connection::read(char* into, std::size_t size) {
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size, length_ - body_read_));
  if (trouble_) return -1;
  if (wanted == 0) return 0;
  const auto taken = [&](std::size_t n) {
    body_read_ += n;
    moved_ += n;
    return static_cast<ssize_t>(n);
  };
  if (!in_.empty()) {
    const std::size_t n = std::min(wanted, in_.size());
    std::copy_n(in_.begin(), n, into);
    in_.erase(0, n);
    return taken(n);
  }
  if (std::exchange(continue_due_, false)) {
    constexpr std::string_view interim = "HTTP/1.1 100 Continue\r\n\r\n";
    (void)::send(socket_, interim.data(), interim.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  for (;;) {
    const ssize_t n = ::recv(socket_, into, wanted, MSG_DONTWAIT);
    if (n > 0) {
      sending_.bytes += static_cast<std::uint64_t>(n);
      return taken(static_cast<std::size_t>(n));
    }
    if (n < 0 && errno == EINTR) continue;
    const bool nothing_yet = n < 0 && errno == EAGAIN;
    const Wait wait = nothing_yet ? wait_for(POLLIN, sending_) : Wait::gone;
    if (wait == Wait::late || evicted_)
      return fail_with(408, {Code::out_of_time, "the body of the request came too slowly", {}, "try again"});
    if (wait == Wait::gone)
      return fail_with(400, {Code::bad_usage,
                             "the body of the request ended after " + std::to_string(body_read_) + " of " +
                                 std::to_string(length_) + " bytes",
                             {},
                             "send it again"});
  }
}

bool Connection::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
      taking_.bytes += static_cast<std::uint64_t>(n);
      moved_ += static_cast<std::uint64_t>(n);
    } else if (n < 0 && errno == EAGAIN) {
      if (wait_for(POLLOUT, taking_) != Wait::ready) return false;
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
  if (in_.empty() && body_read_ == length_ && !trouble_) {
    char next = 0;
    if (::recv(socket_, &next, 1, MSG_PEEK | MSG_DONTWAIT) < 0) return;  // nothing to drop
  }
  enter(Phase::linger);
  std::array<char, 64 * 1024> piece;
  const auto deadline = Clock::now() + linger_time;
  while (wait_for(POLLIN, deadline) == Wait::ready) {
    const ssize_t n = ::recv(socket_, piece.data(), piece.size(), MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) return;
  }
}

}  // namespace vacuform::http
