// The space that the service reserves on the disk of its data folder. Deleting, cancelling, heartbeats, ends of leases
// and the next start need some, so new files must not use the last of it.
//
// The reserve is a twentieth of the disk, from 16 MiB to 256 MiB, and never more than a quarter of the disk. A check
// requires one, two or three quarters of that to stay free. There is also DATA/reserve, a file without contents whose
// space is allocated: if a change of the database still finds the disk full, because other programs write to it too,
// the file is emptied and the change is tried again. The file gets its space back when the disk has space.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "api/base/file.hpp"

namespace vacuform {

// The uses of the disk, by the quarters of the reserve that must stay free.
enum class Use { artifact = 1, begin_job = 2, submission = 3 };

// Bytes.
struct DiskSpace {
  std::uint64_t total = 0, free = 0;  // 0: the system does not tell
  std::uint64_t kept_free = 0;        // that a submission must leave free
};

// From any thread.
class DiskRoom {
 public:
  // Never fails: if the reserve file cannot be made, the service works without it. `kept` in bytes replaces the
  // default.
  static std::shared_ptr<DiskRoom> open(const std::filesystem::path& data,
                                        std::optional<std::uint64_t> kept = std::nullopt);

  // Whether enough space is left after `bytes` more. Errors: disk_full.
  Result<void> check(Use use, std::uint64_t bytes = 0) const;
  DiskSpace space() const;
  // Empties the reserve. False when it was empty already.
  bool give_up();
  // Allocates the space of the reserve again, if the disk has it. Call it regularly.
  void restore();

 private:
  DiskRoom(std::filesystem::path data, std::uint64_t kept, File reserve);

  const std::filesystem::path data_;
  const std::uint64_t kept_, reserve_bytes_;
  std::mutex mutex_;
  File reserve_;
  bool held_ = false;  // the space of the reserve is allocated
};

}  // namespace vacuform
