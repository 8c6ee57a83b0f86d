// A connection to SQLite. SQLite's own header stays in sqlite.cpp. Not for several threads at a time: the store's lock
// holds them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>

#include "server/store/sql.hpp"

struct sqlite3;

namespace vacuform {

class SqliteStatement;

class SqliteDatabase : public Database {
 public:
  SqliteDatabase();
  ~SqliteDatabase() override;

  // Opens or makes the file. Errors here and below: disk_full, unavailable (locked), corrupt_file (not a
  // database).
  Result<void> open(const std::string& path);
  Result<void> execute(const std::string& sql) override;
  Result<Statement*> prepared(const char* sql) override;
  // Its transactions run one at a time.
  Result<void> take_turns(const std::string&) override { return {}; }
  // Copies the database into a new file. Between pieces of a thousand pages `pause` is called, which may let others use
  // the connection; what they change is in the copy. False from it gives up with cancelled.
  Result<void> copy_to(const std::string& path, const std::function<bool()>& pause);
  // Runs `target` for each row of `select`, with the values of the row as its arguments. False from `going`, which is asked
  // before each row, gives up with cancelled.
  Result<void> run_for_rows(const std::string& select, Statement& target, const std::function<bool()>& going);
  // Whether an error since the last call may mean that the disk is full.
  bool take_perhaps_full() { return std::exchange(perhaps_full_, false); }
  // Transactions so far that have changed the file, each of them in it for good.
  std::int64_t commits() const { return commits_; }
  // Steps of SQLite's virtual machine so far: the work that was done, whatever the machine's speed.
  std::int64_t steps() const;

 private:
  friend class SqliteStatement;
  tl::unexpected<Error> error() const;
  static int wrote(void* self, sqlite3* db, const char* name, int pages);

  sqlite3* db_ = nullptr;
  mutable bool perhaps_full_ = false;
  std::int64_t commits_ = 0;
  std::unordered_map<const char*, std::unique_ptr<SqliteStatement>> statements_;
};

// What to do about a damaged database.
inline constexpr const char* damage_fix =
    "restore a backup with vacuform-server restore, or save what can be read with vacuform-server verify "
    "--repair";

// The first fault in the pages of the database, and in its indexes if `full`; empty: none.
enum class PageCheck { quick, full };
Result<std::string> page_fault(Database& db, PageCheck check);

}  // namespace vacuform
