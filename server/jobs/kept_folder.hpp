// What the local workers keep of scans, as the server sees it: a subfolder for each owner and scan, which goes after the last
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

class KeptFolder {
 public:
  // `data` is the server's folder, in which the secret is made when it is absent. start_secrets() comes first. Errors: those of
  // the secret's file and of the store.
  static Result<std::unique_ptr<KeptFolder>> open(const std::filesystem::path& data, Store& store);

  // The folder for work of the local workers; what they keep is in it.
  const std::filesystem::path& workers() const { return workers_; }
  // 64 hexadecimal digits, the same for the same owner and scan. From any thread.
  std::string key(const std::string& owner, const std::string& sha256);
  // Deletes what is kept of scans that no job of their owner names any more. Call it about every second.
  void tidy(Store& store);

 private:
  KeptFolder(const std::filesystem::path& data, std::string secret);

  const std::filesystem::path workers_, kept_;
  const std::string secret_;
  std::mutex mutex_;
  std::map<std::string, std::pair<std::string, std::string>> keys_;  // to owner and scan
};

}  // namespace vacuform
