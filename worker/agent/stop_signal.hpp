// SIGTERM and SIGINT as something to wait for and to look at, and the time that a job has left after them.
#pragma once

#include <atomic>
#include <chrono>

namespace vacuform {

// Make one, before any thread is started: it blocks both signals in this thread and all that follow.
class StopSignal {
 public:
  // `drain`: how long a running job may go on after the signal.
  explicit StopSignal(std::chrono::milliseconds drain = std::chrono::milliseconds(0));
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  // Waits up to `time` (0: only looks); true once a signal has come. Sticky; from any thread.
  bool within(std::chrono::milliseconds time) const;
  // The same for a running job: true once the signal is as old as `drain`. From any thread.
  bool drained_within(std::chrono::milliseconds time) const;

 private:
  using Clock = std::chrono::steady_clock;
  // When the drain ends. Called after the signal; the first call counts its time as that of the signal.
  Clock::time_point end() const;

  int fd_;
  const std::chrono::milliseconds drain_;
  mutable std::atomic<Clock::rep> end_{0};  // ticks of the clock; 0: no signal has been seen
};

}  // namespace vacuform
