// The room that the service keeps on the disk of its data folder. Deleting, cancelling, heartbeats, ends of leases and the
// next start need some, so new files must not take the last of it.
//
// What is kept is a twentieth of the disk, from 16 MiB to 256 MiB, and never more than a quarter of the disk. A check asks
// for one, two or three quarters of that to stay free. Beside it stands DATA/reserve, a file without contents whose space is
// allocated: when a change of the database finds the disk full all the same, because others write to it too, the file is
// emptied and the change is tried again. The file gets its space back when the disk has room.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "api/base/file.hpp"

namespace vacuform {

// What the room is for, by the quarters of the kept bytes that must stay free.
enum class Use { artifact = 1, begin_job = 2, submission = 3 };

// From any thread.
class DiskRoom {
 public:
  // Never fails: where the reserve cannot be made, the service works without it. `kept` in bytes, in place of the default.
  static std::shared_ptr<DiskRoom> open(const std::filesystem::path& data,
                                        std::optional<std::uint64_t> kept = std::nullopt);

  // Whether `bytes` more leave enough room. Errors: disk_full.
  Result<void> check(Use use, std::uint64_t bytes = 0) const;
  // Empties the reserve. False when it was empty already.
  bool give_up();
  // Gives the reserve its space back, if there is room. Call it now and then.
  void restore();

 private:
  DiskRoom(std::filesystem::path data, std::uint64_t kept, File reserve);

  const std::filesystem::path data_;
  const std::uint64_t kept_, reserve_bytes_;
  std::mutex mutex_;
  File reserve_;
  bool held_ = false;  // the reserve has its space
};

}  // namespace vacuform
