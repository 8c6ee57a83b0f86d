// One accepted connection, one request, with limits on everything that a client can make long: the head's
// bytes and lines, the time for the head, for each wait and for the whole body. Nothing after the body that
// Content-Length announced is ever read as a request.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

#include "server/http/message.hpp"

namespace vacuform::http {

struct Limits {
  std::size_t head_bytes = 32 * 1024;
  std::size_t head_lines = 100;
  std::chrono::milliseconds head_time{10'000};
  std::chrono::milliseconds crowded_head_time{100};  // the same while most threads are taken
  std::chrono::milliseconds wait{30'000};            // for the next bytes of a body, or for room to write
  std::uint64_t slowest_body = 4 * 1024;             // bytes a second, on the average after `wait`
};

// What the head says, after the gate: only what the library behind may see.
struct Head {
  std::string request_line;
  std::vector<Header> headers;
  std::uint64_t content_length = 0;
};

class Connection : public Body {
 public:
  // Takes the socket and closes it. `stopping` set makes every wait end within half a second.
  Connection(int socket, const Limits& limits, const std::atomic<bool>& stopping);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Reads and vets the head. False when the client sent nothing and went away; a refusal is kept for the
  // answer.
  bool read_head();
  const Head& head() const { return head_; }
  const std::optional<Refusal>& refusal() const { return refusal_; }

  Result<std::size_t> read(std::span<char> into) override;
  bool write(std::string_view bytes);
  // Says that nothing more will come, and takes in what the client is still sending for a moment, so that a
  // refusal in the middle of an upload reaches it.
  void finish();
  // Whether the client has closed its side, or the connection broke.
  bool gone() const;

 private:
  using Instant = std::chrono::steady_clock::time_point;
  enum class Wait { ready, late, gone };
  Wait wait_for(short events, Instant deadline) const;
  void parse_head(std::string_view text);
  void refuse(int status, std::string what, std::string mend);

  int socket_;
  const Limits limits_;
  const std::atomic<bool>& stopping_;
  Head head_;
  std::optional<Refusal> refusal_;
  std::string early_;  // bytes of the body that came with the head
  std::uint64_t body_read_ = 0;
  Instant body_started_{};
  bool continue_due_ = false;  // the client waits for "100 Continue"
};

}  // namespace vacuform::http
