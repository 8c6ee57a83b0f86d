// Which database has the rows of a data folder: a number that both keep, so that no database is used with the files of
// another, nor an empty one with the files of patients.
#pragma once

#include <filesystem>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

inline constexpr const char* sqlite_name = "sqlite";
inline constexpr const char* postgresql_name = "postgresql";

// In the file DATA/database-id.
struct FolderMark {
  std::string database;  // sqlite_name or postgresql_name; empty: there is no mark
  std::string number;

  bool operator==(const FolderMark&) const = default;
};

// Errors: unreadable; corrupt_file (not a mark).
Result<FolderMark> read_folder_mark(const std::filesystem::path& data);
// Errors: disk_full, unavailable.
Result<void> write_folder_mark(const std::filesystem::path& data, const FolderMark& mark);

// Whether files of jobs lie in the folder. True if that cannot be told.
bool has_blobs(const std::filesystem::path& data);

}  // namespace vacuform
