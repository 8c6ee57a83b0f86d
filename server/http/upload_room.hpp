// Room for large bodies. A route reads one in a thread of its own, which waits for its client, so only so
// many are read at a time. When all room is taken, a new one gets that of the slowest, which ends.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "server/http/message.hpp"

namespace vacuform::http {

// From any thread; outlives the places that it gives.
class UploadRoom {
 public:
  // What is known of a body that is being read. Outlives its place.
  struct Reading {
    int socket = -1;
    std::atomic<std::uint64_t> bytes = 0;
    std::atomic<bool> evicted = false;  // set together with the end of what can be read from the socket
  };
  using Place = std::shared_ptr<void>;  // given back when the last copy goes

  explicit UploadRoom(int most) : most_(static_cast<std::size_t>(most)) {}

  // Null when all room is taken by bodies that are fast, or too new to tell.
  Place take(Reading& reading);

 private:
  using Instant = std::chrono::steady_clock::time_point;
  struct Taken {
    Reading* reading;
    Instant since;
  };
  bool evict_slowest();
  void give_back(const Reading* reading);

  const std::size_t most_;
  std::mutex mutex_;
  std::list<Taken> taken_;
};

}  // namespace vacuform::http
