#include "worker/agent/heartbeat.hpp"

#include <algorithm>

namespace vacuform {

using std::chrono::steady_clock;

Heartbeat::Heartbeat(WorkerClient client, const Lease& lease, JobLog& log)
    : client_(std::move(client)), lease_(lease), log_(log), thread_([this] { beat(); }) {}

Heartbeat::~Heartbeat() {
  {
    std::lock_guard guard(mutex_);  // or beat() might miss the wake-up
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Heartbeat::at(Stage stage, double fraction) {
  std::lock_guard guard(mutex_);
  stage_ = stage;
  fraction_ = fraction;
}

void Heartbeat::beat() {
  const auto pause = std::min(lease_.heartbeat, std::chrono::seconds(1));
  // Counted from before the call that the server answered: the server's clock started later than this one.
  auto renewed = steady_clock::now();
  std::unique_lock guard(mutex_);
  while (!ending_) {
    const Stage stage = stage_;
    const double fraction = fraction_;
    guard.unlock();
    const auto going = [this] { return !ending_; };
    (void)log_.send(client_, lease_, going);  // what is not heard now is sent with the next
    const auto asked = steady_clock::now();
    const auto cancel = client_.heartbeat(lease_, stage, fraction, going);
    if (cancel) {
      renewed = asked;
      if (*cancel) cancel_ = true;
    } else if (cancel.error().code == Code::lease_lost || cancel.error().code == Code::not_found ||
               steady_clock::now() - renewed > lease_.seconds) {
      lost_ = true;
      return;
    }
    guard.lock();
    wake_.wait_for(guard, pause, [this] { return ending_.load(); });
  }
}

}  // namespace vacuform
