#include "server/jobs/worker_caches.hpp"

#include <fcntl.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "api/base/file.hpp"
#include "api/base/file_tree.hpp"
#include "api/base/log.hpp"
#include "api/base/secrets.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

void remove_logged(const fs::path& folder) {
  if (const std::size_t left = remove_tree(AT_FDCWD, folder.c_str()); left > 0)
    log_event("cache-not-deleted", {{"key", folder.filename().string()}, {"entries", left}});
}

}  // namespace

WorkerCaches::WorkerCaches(const fs::path& data, std::string secret)
    : workers_(fs::absolute(data / "workers")), caches_(workers_ / "cache"), secret_(std::move(secret)) {}

Result<std::unique_ptr<WorkerCaches>> WorkerCaches::open(const fs::path& data, Store& store) {
  constexpr std::size_t length = 64;
  const fs::path file = data / "cache-secret";
  std::string secret = read_text_file(file, length).value_or("");
  if (secret.size() != length) {
    secret = random_hex(length / 2);
    VACUFORM_CHECK(write_text_file(file, secret));
  }
  std::unique_ptr<WorkerCaches> made(new WorkerCaches(data, std::move(secret)));
  VACUFORM_TRY(scans, store.scans_of_jobs());
  for (const auto& [owner, sha256] : scans) (void)made->key(owner, sha256);
  return made;
}

std::string WorkerCaches::key(const std::string& owner, const std::string& sha256) {
  std::string key = text_hash(secret_ + text_hash(owner) + sha256);
  const std::lock_guard hold(mutex_);
  keys_.insert_or_assign(key, std::pair(owner, sha256));
  return key;
}

void WorkerCaches::tidy(Store& store) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(caches_, error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename().string());
  for (const std::string& name : names) {
    std::optional<std::pair<std::string, std::string>> scan;
    {
      const std::lock_guard hold(mutex_);
      if (const auto known = keys_.find(name); known != keys_.end()) scan = known->second;
    }
    if (scan && store.names_scan(scan->first, scan->second).value_or(true)) continue;
    remove_logged(caches_ / name);
    const std::lock_guard hold(mutex_);
    keys_.erase(name);
  }
}

}  // namespace vacuform
