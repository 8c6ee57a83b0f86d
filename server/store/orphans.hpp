// Objects in the bucket that no row knows, for example after the database was restored from a backup.
#pragma once

#include <cstdint>
#include <optional>

#include "api/base/clock.hpp"

namespace vacuform {

struct OrphanSearch {
  bool remove = false;
  Millis older_than =
      48 * 3'600'000LL;  // since the object was stored, by the clocks of this machine and of the object store
  // In percent of the objects. If there are more, none is deleted, unless there are at most `few`: the bucket or the
  // database may be another one than the administrator thinks.
  double most = 5;
  static constexpr std::int64_t few = 20;
};

struct OrphanReport {
  std::int64_t objects = 0;  // of blobs, in the bucket
  std::int64_t orphans = 0, deleted = 0;
  std::uint64_t bytes = 0;  // of the orphans
  std::optional<Millis> oldest;
};

}  // namespace vacuform
