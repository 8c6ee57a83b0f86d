// Checks the store again and again while a server uses it: all pages, rows and files, at a bounded rate.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/store/store.hpp"

namespace vacuform {

class StoreWatch {
 public:
  // `every`: from the beginning of one check to that of the next, whichever server of the store makes it. Reads at most
  // `bytes_per_second`.
  StoreWatch(Store& store, std::chrono::milliseconds every, std::uint64_t bytes_per_second);
  StoreWatch(const StoreWatch&) = delete;
  ~StoreWatch();

 private:
  void run();
  void check();
  bool wait(std::chrono::milliseconds time);  // false: the end has come

  Store& store_;
  const std::chrono::milliseconds every_;
  const std::uint64_t bytes_per_second_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace vacuform
