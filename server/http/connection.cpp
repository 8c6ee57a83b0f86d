#include "server/http/connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "server/http/router.hpp"

namespace vacuform::http {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

Connection::Connection(int socket, const Limits& limits, UploadRoom& room, const std::atomic<bool>& stopping)
    : socket_(socket), limits_(limits), room_(room), stopping_(stopping) {
  reading_.socket = socket;
}

Connection::~Connection() { close(); }

void Connection::close() {
  place_.reset();  // before another socket can get the same number
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

Connection::Got Connection::receive() {
  std::array<char, 16 * 1024> piece;
  const std::size_t most = limits_.head_bytes + small_body;
  if (in_.size() >= most) return Got::nothing;
  for (;;) {
    const ssize_t n = ::recv(socket_, piece.data(), std::min(piece.size(), most - in_.size()), MSG_DONTWAIT);
    if (n > 0) {
      in_.append(piece.data(), static_cast<std::size_t>(n));
      return Got::bytes;
    }
    if (n == 0) return Got::end;
    if (errno == EAGAIN || errno == EWOULDBLOCK) return Got::nothing;
    if (errno != EINTR) return Got::end;
  }
}

std::optional<tl::expected<Head, Refusal>> Connection::take_head() {
  const std::size_t end = in_.find("\r\n\r\n", searched_ < 3 ? 0 : searched_ - 3);
  searched_ = in_.size();
  if (std::min(end, in_.size()) > limits_.head_bytes)
    return tl::make_unexpected(
        Refusal{431,
                {Code::too_large,
                 "the head of the request is longer than " + std::to_string(limits_.head_bytes) + " bytes",
                 "request head", "send fewer or shorter header lines"}});
  if (end == std::string::npos) return std::nullopt;
  auto head = parse_head(std::string_view(in_).substr(0, end + 2), limits_);
  in_.erase(0, end + 4);
  length_ = head ? head->content_length : 0;
  continue_due_ = head && head->expects_continue;
  return head;
}

bool Connection::more_arrived() const {
  const std::uint64_t left = length_ - body_read_;
  if (in_.size() != left) return in_.size() > left;
  char next = 0;
  return ::recv(socket_, &next, 1, MSG_PEEK | MSG_DONTWAIT) >= 0;  // also at the end: no more requests come
}

Refusal Connection::too_slow() const {
  return {408, {Code::out_of_time, "the body of the request came too slowly", {}, "try again"}};
}

Refusal Connection::broken_off() const {
  return {400,
          {Code::bad_usage,
           "the body of the request ended after " + std::to_string(body_read_ + in_.size()) + " of " +
               std::to_string(length_) + " bytes",
           {},
           "send it again"}};
}

void Connection::send_continue() {
  if (!std::exchange(continue_due_, false)) return;
  constexpr std::string_view interim = "HTTP/1.1 100 Continue\r\n\r\n";
  (void)::send(socket_, interim.data(), interim.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

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

// Counts only the time spent waiting for the client, not the time of the disk behind the route.
Connection::Wait Connection::wait_for_body() {
  const Instant started = steady_clock::now();
  const Wait wait = wait_for(POLLIN, started + (limits_.wait - waited_) + 1ms);
  waited_ += steady_clock::now() - started;
  if (wait == Wait::gone || waited_ < limits_.wait) return wait;
  const double least =
      static_cast<double>(limits_.slowest_body) * std::chrono::duration<double>(waited_).count();
  if (static_cast<double>(window_bytes_) < least) return Wait::late;
  waited_ = {};
  window_bytes_ = 0;
  return wait == Wait::late ? wait_for_body() : wait;
}

Result<std::size_t> Connection::read(std::span<char> into) {
  const std::uint64_t left = length_ - body_read_;
  const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(into.size(), left));
  if (wanted == 0) return 0;
  if (!in_.empty()) {
    const std::size_t n = std::min(wanted, in_.size());
    std::copy_n(in_.begin(), n, into.begin());
    in_.erase(0, n);
    body_read_ += n;
    return n;
  }
  const auto refuse = [&](Refusal refusal) {
    trouble_ = std::move(refusal);
    return tl::make_unexpected(trouble_->error);
  };
  if (trouble_) return tl::make_unexpected(trouble_->error);
  if (!place_ && !(place_ = room_.take(reading_)))
    return refuse({503, {Code::busy, "too many large bodies arrive at this moment", {}, "try again"}});
  send_continue();
  for (;;) {
    const Wait wait = wait_for_body();
    if (wait == Wait::late) return refuse(too_slow());
    const ssize_t n = wait == Wait::gone ? 0 : ::recv(socket_, into.data(), wanted, MSG_DONTWAIT);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0 && reading_.evicted) return refuse(too_slow());
    if (n <= 0) return tl::make_unexpected(broken_off().error);
    body_read_ += static_cast<std::uint64_t>(n);
    window_bytes_ += static_cast<std::uint64_t>(n);
    reading_.bytes += static_cast<std::uint64_t>(n);
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

void Connection::end_request() {
  place_.reset();
  in_.erase(0, static_cast<std::size_t>(std::min<std::uint64_t>(in_.size(), length_ - body_read_)));
  if (in_.capacity() > 4096 && in_.empty()) std::string().swap(in_);
  searched_ = 0;
  length_ = body_read_ = 0;
  continue_due_ = false;
  trouble_.reset();
}

}  // namespace vacuform::http
