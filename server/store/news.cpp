#include "server/store/news.hpp"

namespace vacuform {

std::optional<bool> News::wait(const std::string& job, std::chrono::milliseconds time,
                               const std::function<bool()>& changed) {
  const auto until = std::chrono::steady_clock::now() + time;
  Waiter self;
  std::unique_lock hold(mutex_);
  if (waiters_.size() >= most_) return std::nullopt;
  const auto place = waiters_.emplace(job, &self);
  bool answer = false;
  do {
    self.heard = false;  // what comes from here on is not in the answer
    hold.unlock();
    answer = changed();
    hold.lock();
  } while (!answer && self.woken.wait_until(hold, until, [&] { return self.heard; }));
  waiters_.erase(place);
  return answer;
}

void News::tell(const std::vector<std::string>& jobs) {
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

}  // namespace vacuform
