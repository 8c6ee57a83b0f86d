// Copies all that a stopped service keeps, rows and blobs, to another place: from SQLite or PostgreSQL with files or an
// object store, to any of these.
//
// The blobs come first, then all rows in one change, so a copy that was interrupted leaves a target without rows, and can
// be repeated: opening the target deletes blobs that no row names. At the end the target is opened again, and its rows
// and the bytes of its blobs are compared with those of the source.
//
// Unfinished uploads begin again, because their bytes are not blobs yet. Jobs that are running keep their leases for
// another `lease`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace vacuform {

struct StorePlace {
  std::filesystem::path data;
  StoreOptions options = {};
};

struct CopyProgress {
  const char* step = "";  // "copied" or "compared": blobs; "added": rows
  std::int64_t blobs = 0, all_blobs = 0;
  std::uint64_t bytes = 0, all_bytes = 0;
  std::int64_t rows = 0;
};

struct CopyReport {
  std::int64_t jobs = 0, blobs = 0;
  std::uint64_t bytes = 0;
  std::vector<std::string> damaged;  // hashes of blobs that were left out, as in BackupReport
};

// `going` may cancel it; `progress` is called after each piece of a blob and before each row. Both are called by this
// thread alone. After an error the target has no rows, unless the error says so. Temporary files are in the target's data
// folder. Errors: not_found (no source), unavailable (a server uses source or target), bad_usage (the target has rows),
// disk_full, cancelled, internal (the copy differs).
Result<CopyReport> copy_store(const StorePlace& from, const StorePlace& to,
                              const std::function<bool()>& going,
                              const std::function<void(const CopyProgress&)>& progress);

}  // namespace vacuform
