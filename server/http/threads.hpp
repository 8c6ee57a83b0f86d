// The threads of cpp-httplib's server, one for each connection: they come as they are needed, up to a limit, and stay.
#pragma once

#include <httplib.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace vacuform::http {

class Threads final : public httplib::TaskQueue {
 public:
  // `crowded` is called with the number of connections that have to wait for a thread. If half as many wait as there are
  // threads, no more are accepted meanwhile.
  Threads(int most, std::function<void(std::size_t waiting)> crowded)
      : most_(most), crowded_(std::move(crowded)) {}
  ~Threads() override { shutdown(); }

  using Enqueued = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));  // void before version 0.14
  Enqueued enqueue(std::function<void()> task) override;
  void shutdown() override;

 private:
  void work();

  const std::size_t most_;
  const std::function<void(std::size_t)> crowded_;
  std::mutex mutex_;
  std::condition_variable wake_, taken_;
  std::deque<std::function<void()>> tasks_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool over_ = false;
};

}  // namespace vacuform::http
