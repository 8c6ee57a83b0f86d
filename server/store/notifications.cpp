#include "server/store/notifications.hpp"

namespace vacuform {

std::optional<bool> Notifications::wait(const std::string& job, std::chrono::milliseconds time,
                                        const std::function<bool()>& changed) {
  const auto until = std::chrono::steady_clock::now() + time;
  Waiter self;
  std::unique_lock hold(mutex_);
  if (waiters_.size() >= most_) return std::nullopt;
  const auto place = waiters_.emplace(job, &self);
  bool answer = false;
  for (;;) {
    self.heard = false;  // what comes from here on is not in the answer
    hold.unlock();
    answer = changed();
    hold.lock();
    const auto now = std::chrono::steady_clock::now();
    if (answer || now >= until) break;
    const auto next = until - now > poll_ ? now + poll_ : until;
    if (!self.woken.wait_until(hold, next, [&] { return self.heard; }) && next == until) break;
  }
  waiters_.erase(place);
  return answer;
}

void Notifications::tell(const std::vector<std::string>& jobs) {
  if (jobs.empty()) return;
  const std::lock_guard hold(mutex_);
  if (waiters_.empty()) return;
  for (const std::string& job : jobs) {
    const auto [begin, end] = waiters_.equal_range(job);
    for (auto it = begin; it != end; ++it) {
      it->second->heard = true;
      it->second->woken.notify_one();
    }
  }
}

void Notifications::tell_all() {
  const std::lock_guard hold(mutex_);
  for (const auto& [job, waiter] : waiters_) {
    waiter->heard = true;
    waiter->woken.notify_one();
  }
}

}  // namespace vacuform
