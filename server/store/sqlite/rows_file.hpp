// A file of SQLite with the rows of a store, for a while.
#pragma once

#include <filesystem>
#include <optional>
#include <utility>

#include "server/store/incoming.hpp"
#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

// Deleted with this object.
class RowsFile {
 public:
  explicit RowsFile(std::filesystem::path path) : path_(std::move(path)) {}
  RowsFile(const RowsFile&) = delete;
  RowsFile& operator=(const RowsFile&) = delete;
  ~RowsFile() {
    db_.reset();
    for (const char* end : {"", "-journal", "-shm", "-wal"}) (void)delete_file(path_.string() + end);
  }
  const std::filesystem::path& path() const { return path_; }
  Result<void> open() {
    db_.emplace();
    return db_->open(path_.string());
  }
  void close() { db_.reset(); }
  SqliteDatabase& db() { return *db_; }

 private:
  const std::filesystem::path path_;
  std::optional<SqliteDatabase> db_;
};

}  // namespace vacuform
