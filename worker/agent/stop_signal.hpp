// SIGTERM and SIGINT as something to wait for and to look at.
#pragma once

#include <chrono>

namespace vacuform {

// Make one, before any thread is started: it blocks both signals in this thread and all that follow.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  // Waits up to `time` (0: only looks); true once a signal has come. Sticky; from any thread.
  bool within(std::chrono::milliseconds time) const;

 private:
  int fd_;
};

}  // namespace vacuform
