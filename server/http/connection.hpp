// One accepted connection and the request that it is at. Its socket never blocks; only the body of a large
// upload and the pieces of a stream are waited for, within the limits.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/head.hpp"
#include "server/http/message.hpp"
#include "server/http/upload_room.hpp"

namespace vacuform::http {

class Connection : public Body {
 public:
  // Takes the socket, which must not block, and closes it. `stopping` set makes every wait end within half a
  // second.
  Connection(int socket, const Limits& limits, UploadRoom& room, const std::atomic<bool>& stopping);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket() const { return socket_; }
  void close();

  enum class Got { bytes, nothing, end };  // nothing: not yet; end: the client will send no more
  // Takes in what has arrived, up to the longest head and the longest small body.
  Got receive();
  // Whether a part of a request, or more, is here.
  bool begun() const { return !in_.empty(); }
  // The next head, once all of it is here. Its body follows.
  std::optional<tl::expected<Head, Refusal>> take_head();
  // The whole body is here, and need not be waited for.
  bool body_arrived() const { return in_.size() >= length_ - body_read_; }
  // More than the announced body has come: a request that did not wait for its answer.
  bool more_arrived() const;

  // Waits for the client where the body is not here yet; see Body.
  Result<std::size_t> read(std::span<char> into) override;
  // Tells a client that waits for it to send the body.
  void send_continue();
  // Why the body could not be read to its end, if it is the client that came too slowly (408) or the server
  // that has no room (503).
  const std::optional<Refusal>& trouble() const { return trouble_; }
  Refusal too_slow() const;
  Refusal broken_off() const;

  // Sends all, as long as the client takes some of it within the limits.
  bool write(std::string_view bytes);
  // Whether the client has closed its side, or the connection broke.
  bool gone() const;
  // Forgets the request, with what is left of its body.
  void end_request();

 private:
  using Instant = std::chrono::steady_clock::time_point;
  enum class Wait { ready, late, gone };
  Wait wait_for(short events, Instant deadline) const;
  Wait wait_for_body();

  int socket_;
  const Limits& limits_;
  UploadRoom& room_;
  const std::atomic<bool>& stopping_;
  std::string in_;            // received and not yet used
  std::size_t searched_ = 0;  // of it, for the end of a head
  std::uint64_t length_ = 0;  // of the body
  std::uint64_t body_read_ = 0;
  bool continue_due_ = false;
  std::optional<Refusal> trouble_;
  UploadRoom::Reading reading_;
  UploadRoom::Place place_;
  std::chrono::steady_clock::duration waited_{};  // in the present window
  std::uint64_t window_bytes_ = 0;
};

}  // namespace vacuform::http
