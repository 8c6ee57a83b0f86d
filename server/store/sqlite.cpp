#include "server/store/sqlite.hpp"

#include <sqlite3.h>

#include <cerrno>

namespace vacuform {

Database::~Database() {
  for (const auto& [sql, statement] : statements_) sqlite3_finalize(statement);
  sqlite3_close(db_);
}

Result<void> Database::open(const std::string& path) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(path.c_str(), &db_, flags, nullptr) != SQLITE_OK) return error();
  sqlite3_wal_hook(db_, wrote, this);
  return {};
}

// After each transaction that wrote to the log. A checkpoint that fails is tried again after the next one.
int Database::wrote(void* self, sqlite3* db, const char* name, int pages) {
  constexpr int most_pages = 1000;
  ++static_cast<Database*>(self)->commits_;
  if (pages >= most_pages) sqlite3_wal_checkpoint_v2(db, name, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  return SQLITE_OK;
}

Result<void> Database::execute(const std::string& sql) {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return {};
}

Result<void> Database::copy_to(const std::string& path, const std::function<bool()>& pause) {
  Database copy;
  VACUFORM_CHECK(copy.open(path));
  sqlite3_backup* backup = sqlite3_backup_init(copy.db_, "main", db_, "main");
  if (!backup) return copy.error();
  int code = SQLITE_OK;
  bool going = true;
  while (going && (code == SQLITE_OK || code == SQLITE_BUSY || code == SQLITE_LOCKED)) {
    code = sqlite3_backup_step(backup, 1000);
    going = pause();
  }
  sqlite3_backup_finish(backup);
  if (code != SQLITE_DONE && !going) return fail(Code::cancelled, "the copy was cancelled");
  if (code != SQLITE_DONE) return copy.error();
  return {};
}

std::int64_t Database::steps() const {
  std::int64_t sum = 0;
  for (const auto& [sql, statement] : statements_)
    sum += sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_VM_STEP, 0);
  return sum;
}

tl::unexpected<Error> Database::error() const {
  const int code = sqlite3_errcode(db_) & 0xff;
  const std::string text = sqlite3_errmsg(db_);
  if (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)
    return fail(Code::corrupt_file, "the job store is damaged: " + text, "jobs.sqlite",
                "restore the data folder from a backup, or start with an empty one");
  // Of other failures SQLite does not always remember the reason; a quota and a late flush give them, too.
  const int system = code == SQLITE_IOERR || code == SQLITE_CANTOPEN ? sqlite3_system_errno(db_) : 0;
  const bool full = code == SQLITE_FULL || system == ENOSPC || system == EDQUOT;
  perhaps_full_ = perhaps_full_ || full || code == SQLITE_IOERR || code == SQLITE_CANTOPEN;
  return fail(full ? Code::disk_full : Code::unavailable, "the job store cannot be used: " + text,
              "jobs.sqlite",
              full ? "free some space on the server's disk and try again"
                   : "check that the server may write to its data folder");
}

Result<sqlite3_stmt*> Database::prepared(const char* sql) {
  sqlite3_stmt*& statement = statements_[sql];
  if (!statement &&
      sqlite3_prepare_v3(db_, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr) != SQLITE_OK)
    return error();
  return statement;
}

Query::~Query() {
  if (!prepared_) return;
  sqlite3_reset(*prepared_);
  sqlite3_clear_bindings(*prepared_);
}

Result<bool> Query::row() {
  if (!prepared_) return tl::make_unexpected(prepared_.error());
  const int code = sqlite3_step(*prepared_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) return db_.error();
  return code == SQLITE_ROW;
}

Result<void> Query::run() {
  const auto stepped = row();
  if (!stepped) return tl::make_unexpected(stepped.error());
  return {};
}

bool Query::null(int column) const { return sqlite3_column_type(*prepared_, column) == SQLITE_NULL; }
std::int64_t Query::integer(int column) const { return sqlite3_column_int64(*prepared_, column); }
double Query::real(int column) const { return sqlite3_column_double(*prepared_, column); }

std::string Query::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(*prepared_, column));
  return bytes ? std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(*prepared_, column)))
               : std::string();
}

void Query::bind(int index, std::string_view value) {
  sqlite3_bind_text(*prepared_, index, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
}
void Query::bind(int index, std::int64_t value) { sqlite3_bind_int64(*prepared_, index, value); }
void Query::bind(int index, double value) { sqlite3_bind_double(*prepared_, index, value); }

}  // namespace vacuform
