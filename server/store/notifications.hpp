// Waiting for events of a job: a waiting thread is woken when a transaction that changed the job has committed. In
// memory only: a client that a restart disconnects asks again.
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

// From any thread. Each waiter occupies a thread, so their number is limited.
class Notifications {
 public:
  // A waiter looks again after `poll` even if it was told of no change.
  explicit Notifications(std::size_t most_waiters, std::chrono::milliseconds poll = std::chrono::hours(1))
      : most_(most_waiters), poll_(poll) {}

  // Calls `changed` at once, and again after every change of the job, until it returns true or the time is over;
  // returns its last answer. nullopt if too many threads are waiting already.
  std::optional<bool> wait(const std::string& job, std::chrono::milliseconds time,
                           const std::function<bool()>& changed);
  void tell(const std::vector<std::string>& jobs);
  // After a time in which changes may have been missed.
  void tell_all();

 private:
  struct Waiter {
    std::condition_variable woken;
    bool heard = false;
  };
  const std::size_t most_;
  const std::chrono::milliseconds poll_;
  std::mutex mutex_;
  std::multimap<std::string, Waiter*> waiters_;  // by job
};

}  // namespace vacuform
