// The caches of jobs (stage_cache.hpp), in a folder of a worker with one subfolder for each owner and scan. The
// name of the subfolder is a key that the server sends with the lease; it reveals neither owner nor scan. The child of
// a job may use only its own subfolder. A scan that exploits a parser finds there what jobs of the same owner made from
// the same scan, and no other patient. What it leaves there can only mislead the jobs of that owner for that scan.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// Several workers may share one folder.
class ScanCaches {
 public:
  // Creates the folder if it is absent, for this user only. Errors: unreadable.
  static Result<ScanCaches> open(std::filesystem::path folder, std::uint64_t most_bytes,
                                 std::chrono::hours longest);

  // The subfolder for a key (64 hexadecimal digits), created if absent, and marked as used now. Errors: unreadable,
  // bad_usage (not a key).
  Result<std::filesystem::path> of(const std::string& key) const;
  // Deletes subfolders that contain a folder or more than most_files files, and those not used for longer than
  // `longest`. Then deletes the least recently used ones until at most `most_bytes` are left. Returns the number of
  // subfolders deleted, and logs those that cannot be deleted.
  int make_room() const;

  static constexpr std::size_t most_files = 200;

 private:
  ScanCaches(std::filesystem::path folder, std::uint64_t most_bytes, std::chrono::hours longest)
      : folder_(std::move(folder)), most_bytes_(most_bytes), longest_(longest) {}
  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  std::chrono::hours longest_;
};

}  // namespace vacuform
