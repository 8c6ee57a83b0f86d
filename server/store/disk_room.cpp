#include "server/store/disk_room.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"

namespace vacuform {

namespace {

constexpr std::uint64_t mebibyte = 1 << 20;
constexpr std::uint64_t largest_reserve = 16 * mebibyte;  // SQLite's log has 4 MiB between its checkpoints
constexpr std::uint64_t least_files = 64;  // that must remain possible, where a disk counts them

struct Space {
  std::uint64_t bytes = 0, free = 0, free_files = 0;
};

// None when the system does not tell.
std::optional<Space> space_of(const std::filesystem::path& data) {
  struct statvfs status {};
  if (::statvfs(data.c_str(), &status) != 0) return std::nullopt;
  return Space{status.f_blocks * status.f_frsize, status.f_bavail * status.f_frsize,
               status.f_files == 0 ? std::numeric_limits<std::uint64_t>::max() : status.f_favail};
}

std::uint64_t kept_of(std::uint64_t disk) {
  return std::min(std::clamp(disk / 20, 16 * mebibyte, 256 * mebibyte), disk / 4);
}

// What each use must leave free.
std::uint64_t least_free(std::uint64_t kept, Use use) { return kept / 4 * static_cast<std::uint64_t>(use); }

}  // namespace

DiskRoom::DiskRoom(std::filesystem::path data, std::uint64_t kept, File reserve)
    : data_(std::move(data)),
      kept_(kept),
      reserve_bytes_(std::min(kept / 4, largest_reserve)),
      reserve_(std::move(reserve)) {}

std::shared_ptr<DiskRoom> DiskRoom::open(const std::filesystem::path& data,
                                         std::optional<std::uint64_t> kept) {
  const auto space = space_of(data);
  File file(::open((data / "reserve").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
  std::shared_ptr<DiskRoom> room(
      new DiskRoom(data, kept.value_or(space ? kept_of(space->bytes) : 0), std::move(file)));
  struct stat status {};
  if (room->reserve_.is_open() && ::fstat(room->reserve_.descriptor(), &status) == 0)
    room->held_ = room->reserve_bytes_ > 0 &&
                  static_cast<std::uint64_t>(status.st_blocks) * 512 >= room->reserve_bytes_;
  if (!room->held_ && room->reserve_.is_open()) (void)!::ftruncate(room->reserve_.descriptor(), 0);
  if (space && space->free < room->kept_ / 4) room->give_up();  // the start itself needs some
  room->restore();
  return room;
}

Result<void> DiskRoom::check(Use use, std::uint64_t bytes) const {
  const auto space = space_of(data_);
  if (!space) return {};
  const std::uint64_t least = least_free(kept_, use);
  if (space->free >= least && space->free - least >= bytes && space->free_files >= least_files) return {};
  return fail(Code::disk_full, "the server's disk has no room for this", {},
              "delete jobs, scans or uploads that are no longer needed, or free some space on the disk");
}

DiskSpace DiskRoom::space() const {
  const Space space = space_of(data_).value_or(Space());
  return {space.bytes, space.free, least_free(kept_, Use::submission)};
}

bool DiskRoom::give_up() {
  const std::lock_guard hold(mutex_);
  if (!held_ || ::ftruncate(reserve_.descriptor(), 0) != 0) return false;
  held_ = false;
  log_event("disk-reserve-used", {{"bytes", reserve_bytes_}});
  return true;
}

void DiskRoom::restore() {
  const std::lock_guard hold(mutex_);
  if (held_ || !reserve_.is_open() || reserve_bytes_ == 0 || !check(Use::submission, reserve_bytes_)) return;
  held_ = ::posix_fallocate(reserve_.descriptor(), 0, static_cast<off_t>(reserve_bytes_)) == 0;
  if (!held_) (void)!::ftruncate(reserve_.descriptor(), 0);
}

}  // namespace vacuform
