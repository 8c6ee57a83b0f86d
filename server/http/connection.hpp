// One accepted connection and its current request. Its socket never blocks; the server waits only for the body of a
// large upload and for the pieces of a stream, within the limits.
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
  // Takes ownership of the socket, which must be non-blocking. Setting `stopping` ends every wait within half a second.
  Connection(int socket, const Limits& limits, UploadRoom& room, const std::atomic<bool>& stopping);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket() const { return socket_; }
  void close();

  enum class Got { bytes, nothing, end };  // nothing: not yet; end: the client will send no more
  // Reads what has arrived, up to the longest head and the longest small body.
  Got receive();
  // Whether any part of a request has arrived.
  bool started() const { return !in_.empty(); }
  // The next head, once it is complete. Its body follows.
  std::optional<tl::expected<Head, Refusal>> take_head();
  // Whether the whole body has arrived.
  bool body_arrived() const { return in_.size() >= length_ - body_read_; }
  // More than the announced body has arrived: the client did not wait for its answer.
  bool more_arrived() const;

  // Waits for the client if the body has not arrived yet; see Body.
  Result<std::size_t> read(std::span<char> into) override;
  // Tells a client that waits for permission to send the body.
  void send_continue();
  // Why the body could not be read to its end, if the client was too slow (408) or the server has no capacity (503).
  const std::optional<Refusal>& trouble() const { return trouble_; }
  Refusal too_slow() const;
  Refusal broken_off() const;

  // Sends everything, as long as the client reads some of it within the limits.
  bool write(std::string_view bytes);
  // Whether the client has closed its side, or the connection failed.
  bool gone() const;
  // Discards the request and the rest of its body.
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
  std::chrono::steady_clock::duration waited_{};  // in the current window
  std::uint64_t window_bytes_ = 0;
};

}  // namespace vacuform::http
