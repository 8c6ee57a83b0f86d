// The socket of one client, for one request. Every wait for the client ends: after a time, when the client is slower than
// it may be, when the server stops, or when another client needs the place.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/messages/head.hpp"
#include "server/messages/message.hpp"

namespace vacuform::http {

class Connection {
 public:
  using Clock = std::chrono::steady_clock;
  // What the connection waits for. Work never makes room.
  enum class Phase { head, body, work, answer, linger };

  // Takes ownership of the socket. Setting `stopping` ends every wait within half a second.
  Connection(int socket, const Limits& limits, const std::atomic<bool>& stopping);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket() const { return socket_; }

  // Waits for the head. No value: the client left without a request. The body follows with read().
  std::optional<tl::expected<Head, Refusal>> read_head();
  // Waits for bytes of the body: at least one, 0 at its end, -1 if it does not come; then trouble() says why.
  ssize_t read(char* into, std::size_t size);
  const std::optional<Refusal>& trouble() const { return trouble_; }
  // False if the client is gone or takes the bytes too slowly.
  bool write(std::string_view bytes);
  // Whether the client has left.
  bool gone() const;
  // After the answer. What the client still sends is dropped for a while: to close with unread bytes would reset the
  // connection and lose the answer on its way.
  void finish();

  void enter(Phase phase);
  // Whether it waits for a head, or only for the client to close.
  bool idle() const { return phase_ == Phase::head || phase_ == Phase::linger; }
  // From any thread: ends the connection.
  void evict();
  // From any thread: what to end first, the lowest; none if it must stay.
  using Rank = std::pair<int, double>;
  std::optional<Rank> rank(Clock::time_point now) const;

 private:
  enum class Wait { ready, late, gone };
  // How much a client sent or took while the server waited for it.
  struct Pace {
    Clock::duration waited{};
    std::uint64_t bytes = 0;
  };
  Wait wait_for(short events, Clock::time_point deadline) const;
  Wait wait_for(short events, Pace& pace) const;
  ssize_t fail_with(int status, Error error);

  const int socket_;
  const Limits& limits_;
  const std::atomic<bool>& stopping_;
  std::string in_;  // what arrived and was not read yet
  std::uint64_t length_ = 0, body_read_ = 0;
  bool continue_due_ = false;
  std::optional<Refusal> trouble_;
  Pace sending_, taking_;
  std::atomic<bool> evicted_ = false;
  std::atomic<Phase> phase_ = Phase::head;
  std::atomic<Clock::time_point> since_ = Clock::now();
  std::atomic<std::uint64_t> moved_ = 0;  // bytes of the phase
};

}  // namespace vacuform::http
