// The caches of the local workers, as the server sees them: a subfolder for each owner and scan, which goes after the last
// job of that owner that names the scan. Its name is a key that tells a worker neither the owner nor the scan: it is made with
// a secret of the server's.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/store/store.hpp"

namespace vacuform {

class WorkerCaches {
 public:
  // `data` is the server's folder, in which the secret is made when it is absent. start_secrets() comes first. Errors: those of
  // the secret's file and of the store.
  static Result<std::unique_ptr<WorkerCaches>> open(const std::filesystem::path& data, Store& store);

  // The folder for work of the local workers; their caches are in it.
  const std::filesystem::path& workers() const { return workers_; }
  // 64 hexadecimal digits, the same for the same owner and scan. From any thread.
  std::string key(const std::string& owner, const std::string& sha256);
  // Deletes the caches of scans that no job of their owner names any more. Call it about every second.
  void tidy(Store& store);

 private:
  WorkerCaches(const std::filesystem::path& data, std::string secret);

  const std::filesystem::path workers_, caches_;
  const std::string secret_;
  std::mutex mutex_;
  std::map<std::string, std::pair<std::string, std::string>> keys_;  // to owner and scan
};

}  // namespace vacuform
