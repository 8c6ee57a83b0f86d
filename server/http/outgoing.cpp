#include "server/http/outgoing.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"

namespace vacuform::http {

namespace {

constexpr std::size_t turn_bytes = 1 << 20;  // sent at a time before others get their turn

// The bytes that the socket took; 0: none at present; -1: the client is gone.
ssize_t send_now(int socket, std::string_view bytes, bool more) {
  for (;;) {
    const ssize_t n =
        ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT | (more ? MSG_MORE : 0));
    if (n >= 0) return n;
    if (errno == EAGAIN || errno == EWOULDBLOCK) return 0;
    if (errno != EINTR) return -1;
  }
}

}  // namespace

Outgoing::Outgoing(std::string text, std::optional<SourceBody> body)
    : text_(std::move(text)), body_(std::move(body)) {
  if (body_ && !body_->sha256.empty()) hash_ = std::make_unique<Sha256>();
}

Outgoing::Sent Outgoing::send(int socket) {
  while (text_sent_ < text_.size()) {
    const ssize_t n = send_now(socket, std::string_view(text_).substr(text_sent_), body_.has_value());
    if (n < 0) return Sent::broken;
    if (n == 0) return Sent::blocked;
    text_sent_ += static_cast<std::size_t>(n);
    sent_ += static_cast<std::uint64_t>(n);
  }
  if (!body_) return Sent::all;
  std::string().swap(text_);
  text_sent_ = 0;
  std::size_t budget = turn_bytes;
  return send_source(socket, budget);
}

Outgoing::Sent Outgoing::send_source(int socket, std::size_t& budget) {
  std::array<char, 64 * 1024> piece;
  while (body_sent_ < body_->bytes) {
    if (budget == 0) return Sent::paused;
    const std::uint64_t left = body_->bytes - body_sent_;
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>({piece.size(), left, std::uint64_t{budget}}));
    const auto got = body_->source->read_at(body_->offset + body_sent_, {piece.data(), wanted});
    if (!got || *got == 0) return Sent::broken;
    const std::string_view bytes(piece.data(), *got);
    if (!right(body_sent_, bytes)) return Sent::broken;
    const ssize_t n = send_now(socket, bytes, bytes.size() < left);
    if (n < 0) return Sent::broken;
    if (n == 0) return Sent::blocked;
    body_sent_ += static_cast<std::uint64_t>(n);
    sent_ += static_cast<std::uint64_t>(n);
    budget -= static_cast<std::size_t>(n);
  }
  return Sent::all;
}

// Hashes what was not seen before of a piece that perhaps is sent again in part; false when the last one
// shows that the body is not the one that it should be.
bool Outgoing::right(std::uint64_t offset, std::string_view piece) {
  if (!hash_ || offset + piece.size() <= hashed_) return true;
  hash_->add(piece.substr(static_cast<std::size_t>(hashed_ - offset)));
  hashed_ = offset + piece.size();
  if (hashed_ < body_->bytes || hash_->hex() == body_->sha256) return true;
  log_event("blob-damaged", {{"blob", body_->sha256}});
  body_->source->doubt();
  return false;
}

}  // namespace vacuform::http
