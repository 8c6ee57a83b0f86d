// What jobs kept of their stages (kept_stages.hpp), in a folder of a worker with one subfolder for each owner and scan. Its
// name is a key that the server gives with the lease, which shows neither. A job's child may use its own subfolder alone: a
// scan that takes over a parser finds there what the same owner's jobs made of the same scan, and no other patient. What it
// leaves there can mislead that owner's jobs of that very scan and no others.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// Several workers may share one folder.
class KeptScans {
 public:
  // The folder is made when absent, for this user alone. Errors: unreadable.
  static Result<KeptScans> open(std::filesystem::path folder, std::uint64_t most_bytes,
                                std::chrono::hours longest);

  // The subfolder for a key (64 hexadecimal digits), made when absent, and used from now on. Errors: unreadable, bad_usage
  // (not a key).
  Result<std::filesystem::path> of(const std::string& key) const;
  // Deletes what holds a folder or more than most_files files, what was not used for longer than `longest`, and of the rest
  // what was used the longest ago until no more than `most_bytes` are left. Gives the number of subfolders deleted, and logs
  // those that could not be.
  int make_room() const;

  static constexpr std::size_t most_files = 200;

 private:
  KeptScans(std::filesystem::path folder, std::uint64_t most_bytes, std::chrono::hours longest)
      : folder_(std::move(folder)), most_bytes_(most_bytes), longest_(longest) {}
  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  std::chrono::hours longest_;
};

}  // namespace vacuform
