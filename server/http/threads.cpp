#include "server/http/threads.hpp"

#include <chrono>
#include <utility>

namespace vacuform::http {

Threads::Enqueued Threads::enqueue(std::function<void()> task) {
  std::unique_lock hold(mutex_);
  tasks_.push_back(std::move(task));
  if (idle_ < tasks_.size() && threads_.size() < most_) threads_.emplace_back([this] { work(); });
  wake_.notify_one();
  while (tasks_.size() > idle_ && threads_.size() == most_) {
    const std::size_t waiting = tasks_.size() - idle_;
    hold.unlock();
    crowded_(waiting);
    hold.lock();
    taken_.wait_for(hold, std::chrono::milliseconds(100), [&] { return tasks_.size() <= most_ / 2; });
    if (tasks_.size() <= most_ / 2) break;
  }
  return Enqueued(true);
}

void Threads::shutdown() {
  {
    const std::lock_guard hold(mutex_);
    over_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

void Threads::work() {
  std::unique_lock hold(mutex_);
  for (;;) {
    ++idle_;
    wake_.wait(hold, [&] { return over_ || !tasks_.empty(); });
    --idle_;
    if (tasks_.empty()) return;
    const auto task = std::move(tasks_.front());
    tasks_.pop_front();
    taken_.notify_one();
    hold.unlock();
    task();
    hold.lock();
  }
}

}  // namespace vacuform::http
