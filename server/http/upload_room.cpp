#include "server/http/upload_room.hpp"

#include <sys/socket.h>

namespace vacuform::http {

using namespace std::chrono_literals;

namespace {

constexpr auto trial = 1s;             // before which nobody can tell how fast a body comes
constexpr double fast = 256.0 * 1024;  // bytes a second; such a body ends soon enough

}  // namespace

UploadRoom::Place UploadRoom::take(Reading& reading) {
  const std::lock_guard hold(mutex_);
  if (taken_.size() >= most_ && !evict_slowest()) return nullptr;
  taken_.push_back({&reading, std::chrono::steady_clock::now()});
  return Place(static_cast<void*>(&reading), [this, &reading](void*) { give_back(&reading); });
}

bool UploadRoom::evict_slowest() {
  const auto now = std::chrono::steady_clock::now();
  auto slowest = taken_.end();
  double least = fast;
  for (auto it = taken_.begin(); it != taken_.end(); ++it) {
    if (now - it->since < trial) continue;
    const double seconds = std::chrono::duration<double>(now - it->since).count();
    const double rate = static_cast<double>(it->reading->bytes) / seconds;
    if (rate >= least) continue;
    least = rate;
    slowest = it;
  }
  if (slowest == taken_.end()) return false;
  slowest->reading->evicted = true;
  ::shutdown(slowest->reading->socket, SHUT_RD);
  taken_.erase(slowest);
  return true;
}

void UploadRoom::give_back(const Reading* reading) {
  const std::lock_guard hold(mutex_);
  taken_.remove_if([&](const Taken& taken) { return taken.reading == reading; });
}

}  // namespace vacuform::http
