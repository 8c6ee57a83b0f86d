#include "server/store/store_watch.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"

namespace vacuform {

using std::chrono::milliseconds;

StoreWatch::StoreWatch(Store& store, milliseconds every, std::uint64_t bytes_per_second)
    : store_(store), every_(every), bytes_per_second_(bytes_per_second), thread_([this] { run(); }) {}

StoreWatch::~StoreWatch() {
  {
    const std::lock_guard hold(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool StoreWatch::wait(milliseconds time) {
  std::unique_lock hold(mutex_);
  return !changed_.wait_for(hold, time, [this] { return ending_; });
}

void StoreWatch::run() {
  const milliseconds pause = std::clamp(every_ / 10, milliseconds(10), milliseconds(60'000));
  while (wait(pause)) {
    const auto status = store_.status();
    if (status && status->last_check && wall_clock() - *status->last_check < every_.count()) continue;
    check();
  }
}

void StoreWatch::check() {
  const auto began = std::chrono::steady_clock::now();
  std::uint64_t read = 0;
  const auto checked = store_.check(true, [&](std::uint64_t bytes) {
    read += bytes;
    const milliseconds due(1000 * read / bytes_per_second_);
    const auto early =
        std::chrono::duration_cast<milliseconds>(began + due - std::chrono::steady_clock::now());
    return wait(std::max(milliseconds(0), early));
  });
  if (!checked && checked.error().code == Code::cancelled) return;
  if (!checked) {
    log_event("store-check-failed", {{"problem", checked.error().text()}});
    (void)wait(std::min(every_, milliseconds(3'600'000)));
    return;
  }
  log_event("store-checked", {{"jobs", checked->jobs},
                              {"files", checked->files},
                              {"bytes", checked->bytes},
                              {"damaged_jobs", checked->damaged_jobs.size()},
                              {"damaged_files", checked->damaged_files.size()},
                              {"missing_files", checked->missing_files.size()},
                              {"files_without_job", checked->unnamed.size()},
                              {"pages", checked->pages.empty() ? "good" : checked->pages}});
}

}  // namespace vacuform
