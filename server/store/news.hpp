// Waiting for news of a job: whoever waits is woken when a transaction that changed the job has committed. In memory alone:
// a waiter that a restart cuts off asks again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace vacuform {

// From any thread. Each waiter holds a thread, so their number has a bound.
class News {
 public:
  explicit News(std::size_t most_waiters) : most_(most_waiters) {}

  // Asks `changed` at once, and again whenever there is news of the job, until it gives true or the time is over; gives
  // its last answer. None when too many wait already.
  std::optional<bool> wait(const std::string& job, std::chrono::milliseconds time,
                           const std::function<bool()>& changed);
  void tell(const std::vector<std::string>& jobs);

 private:
  struct Waiter {
    std::condition_variable woken;
    bool heard = false;
  };
  const std::size_t most_;
  std::mutex mutex_;
  std::multimap<std::string, Waiter*> waiters_;  // by job
};

}  // namespace vacuform
