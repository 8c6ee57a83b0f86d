#include "worker/agent/stop_signal.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

namespace vacuform {

StopSignal::StopSignal(std::chrono::milliseconds drain) : drain_(drain) {
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, SIGTERM);
  ::sigaddset(&set, SIGINT);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  fd_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

StopSignal::~StopSignal() { ::close(fd_); }

// The signal is never read, so that the descriptor stays readable.
bool StopSignal::within(std::chrono::milliseconds time) const {
  pollfd waiting{fd_, POLLIN, 0};
  return ::poll(&waiting, 1, static_cast<int>(time.count())) > 0;
}

StopSignal::Clock::time_point StopSignal::end() const {
  Clock::rep seen = 0;
  const auto now = (Clock::now() + drain_).time_since_epoch().count();
  if (end_.compare_exchange_strong(seen, now)) seen = now;
  return Clock::time_point(Clock::duration(seen));
}

bool StopSignal::drained_within(std::chrono::milliseconds time) const {
  const auto until = Clock::now() + time;
  if (!within(time)) return false;
  std::this_thread::sleep_until(std::min(until, end()));
  return Clock::now() >= end();
}

}  // namespace vacuform
