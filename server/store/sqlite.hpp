// A connection to SQLite and prepared statements, as the store needs them. SQLite's own header stays in
// sqlite.cpp. Not for several threads at a time: the store's lock holds them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "api/base/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace vacuform {

class Database {
 public:
  Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  // Opens or makes the file. Errors here and below: disk_full, unavailable (locked), corrupt_file (not a
  // database).
  Result<void> open(const std::string& path);
  // One or several statements without arguments and results.
  Result<void> execute(const std::string& sql);
  // Copies the database into a new file. Between pieces of a thousand pages `pause` is called, which may let others use
  // the connection; what they change is in the copy. False from it gives up with cancelled.
  Result<void> copy_to(const std::string& path, const std::function<bool()>& pause);
  // Whether an error since the last call may mean that the disk is full.
  bool take_perhaps_full() { return std::exchange(perhaps_full_, false); }
  // Transactions so far that have changed the file, each of them in it for good.
  std::int64_t commits() const { return commits_; }
  // Steps of SQLite's virtual machine so far: the work that was done, whatever the machine's speed.
  std::int64_t steps() const;

 private:
  friend class Query;
  tl::unexpected<Error> error() const;
  static int wrote(void* self, sqlite3* db, const char* name, int pages);
  // Statements live as long as the connection; `sql` is a literal, so its address identifies it.
  Result<sqlite3_stmt*> prepared(const char* sql);

  sqlite3* db_ = nullptr;
  mutable bool perhaps_full_ = false;
  std::int64_t commits_ = 0;
  std::unordered_map<const char*, sqlite3_stmt*> statements_;
};

// One use of a prepared statement: the arguments in, in the order of the question marks, and the rows out.
class Query {
 public:
  template <class... Arguments>
  Query(Database& db, const char* sql, const Arguments&... arguments) : db_(db), prepared_(db.prepared(sql)) {
    int index = 0;
    if (prepared_) (bind(++index, arguments), ...);
  }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
  ~Query();

  // Steps to the next row; false after the last.
  Result<bool> row();
  // For statements that give no rows.
  Result<void> run();

  // The columns of the row, from 0.
  bool null(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;

 private:
  void bind(int index, std::string_view value);
  void bind(int index, std::int64_t value);
  void bind(int index, std::uint64_t value) { bind(index, static_cast<std::int64_t>(value)); }
  void bind(int index, int value) { bind(index, static_cast<std::int64_t>(value)); }
  void bind(int index, double value);
  void bind(int index, const std::string& value) { bind(index, std::string_view(value)); }
  template <class T>
  void bind(int index, const std::optional<T>& value) {  // none is NULL
    if (value) bind(index, *value);
  }

  Database& db_;
  Result<sqlite3_stmt*> prepared_;
};

}  // namespace vacuform
