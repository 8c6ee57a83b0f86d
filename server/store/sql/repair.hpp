// What an operator does about a data folder whose database or files were lost or damaged: of a stopped server, with its
// jobs in SQLite and their files in the folder. Nothing is deleted; what is replaced goes to DATA/quarantine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// Rewrites the database if its pages or indexes are damaged, from the rows that can be read; true if so. Errors:
// corrupt_file (rows cannot be read: only a backup helps), unavailable, disk_full.
Result<bool> repair_pages(const std::filesystem::path& data);

// Moves what a check of the store found: damaged files, files that no row names, and the rows of damaged jobs, which become
// files of JSON. Errors: unavailable, disk_full.
Result<void> set_damage_in_quarantine(const std::filesystem::path& data, Store& store,
                                      const StoreCheck& found);

struct RestoreReport {
  std::int64_t jobs = 0, files = 0;
  std::vector<std::string> damaged;  // hashes of files that the backup has not, or damaged
};
// Puts a backup in the place of the database and adds its files. Errors: bad_usage (not a backup), corrupt_file (the
// backup's database is damaged), unavailable, disk_full.
Result<RestoreReport> restore_backup(const std::filesystem::path& backup, const std::filesystem::path& data);

}  // namespace vacuform
