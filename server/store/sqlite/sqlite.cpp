#include "server/store/sqlite/sqlite.hpp"

#include <sqlite3.h>

#include <cerrno>

#include "api/base/file.hpp"

namespace vacuform {

class SqliteStatement : public Statement {
 public:
  SqliteStatement(SqliteDatabase& db, sqlite3_stmt* statement) : db_(db), statement_(statement) {}
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;
  ~SqliteStatement() override { sqlite3_finalize(statement_); }

  void bind(int index, std::string_view value) override {
    sqlite3_bind_text(statement_, index, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }
  void bind(int index, std::int64_t value) override { sqlite3_bind_int64(statement_, index, value); }
  void bind(int index, double value) override { sqlite3_bind_double(statement_, index, value); }
  Result<bool> step() override {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) return db_.error();
    return code == SQLITE_ROW;
  }
  void reset() override {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
  }
  bool null(int column) const override { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::int64_t integer(int column) const override { return sqlite3_column_int64(statement_, column); }
  double real(int column) const override { return sqlite3_column_double(statement_, column); }
  std::string text(int column) const override {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return bytes ? std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)))
                 : std::string();
  }
  // Makes a column of the row, from 0, the argument of another statement in the same place.
  void bind_to(Statement& target, int column) const {
    const int type = sqlite3_column_type(statement_, column);
    if (type == SQLITE_INTEGER) target.bind(column + 1, integer(column));
    if (type == SQLITE_FLOAT) target.bind(column + 1, real(column));
    if (type == SQLITE_TEXT) target.bind(column + 1, text(column));
  }
  std::int64_t steps() const { return sqlite3_stmt_status(statement_, SQLITE_STMTSTATUS_VM_STEP, 0); }

 private:
  SqliteDatabase& db_;
  sqlite3_stmt* statement_;
};

SqliteDatabase::SqliteDatabase() = default;

SqliteDatabase::~SqliteDatabase() {
  statements_.clear();
  sqlite3_close(db_);
}

Result<void> SqliteDatabase::open(const std::string& path) {
  // Without its count of memory, which nobody reads, SQLite needs no lock for each allocation.
  [[maybe_unused]] static const int configured = sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(path.c_str(), &db_, flags, nullptr) != SQLITE_OK) return error();
  sqlite3_wal_hook(db_, wrote, this);
  return {};
}

// After each transaction that wrote to the log. A checkpoint that fails is tried again after the next one.
int SqliteDatabase::wrote(void* self, sqlite3* db, const char* name, int pages) {
  constexpr int most_pages = 1000;
  ++static_cast<SqliteDatabase*>(self)->commits_;
  if (pages >= most_pages) sqlite3_wal_checkpoint_v2(db, name, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  return SQLITE_OK;
}

Result<void> SqliteDatabase::execute(const std::string& sql) {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return {};
}

Result<void> SqliteDatabase::copy_to(const std::string& path, const std::function<bool()>& pause) {
  SqliteDatabase copy;
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

Result<void> SqliteDatabase::run_for_rows(const std::string& select, Statement& target,
                                          const std::function<bool()>& going) {
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v2(db_, select.c_str(), -1, &made, nullptr) != SQLITE_OK) return error();
  SqliteStatement rows(*this, made);
  for (;;) {
    if (!going()) return fail(Code::cancelled, "the copy was cancelled");
    VACUFORM_TRY(more, rows.step());
    if (!more) return {};
    for (int i = 0; i < sqlite3_column_count(made); ++i) rows.bind_to(target, i);
    const auto ran = target.step();
    target.reset();
    if (!ran) return tl::make_unexpected(ran.error());
  }
}

std::int64_t SqliteDatabase::steps() const {
  std::int64_t sum = 0;
  for (const auto& [sql, statement] : statements_) sum += statement->steps();
  return sum;
}

tl::unexpected<Error> SqliteDatabase::error() const {
  const int code = sqlite3_errcode(db_) & 0xff;
  const std::string text = sqlite3_errmsg(db_);
  if (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)
    return fail(code == SQLITE_NOTADB ? Code::corrupt_file : Code::internal,
                "the job store is damaged: " + text, "jobs.sqlite", damage_fix);
  const int cause = sqlite3_extended_errcode(db_);
  if ((cause == SQLITE_IOERR_FSYNC || cause == SQLITE_IOERR_DIR_FSYNC) && sqlite3_system_errno(db_) == EIO)
    flush_failed();
  // Of other failures SQLite does not always remember the reason; a quota and a late flush give them, too.
  const int system = code == SQLITE_IOERR || code == SQLITE_CANTOPEN ? sqlite3_system_errno(db_) : 0;
  const bool full = code == SQLITE_FULL || system == ENOSPC || system == EDQUOT;
  perhaps_full_ = perhaps_full_ || full || code == SQLITE_IOERR || code == SQLITE_CANTOPEN;
  return fail(full ? Code::disk_full : Code::unavailable, "the job store cannot be used: " + text,
              "jobs.sqlite",
              full ? "free some space on the server's disk and try again"
                   : "check that the server may write to its data folder");
}

Result<Statement*> SqliteDatabase::prepared(const char* sql) {
  auto& statement = statements_[sql];
  if (statement) return statement.get();
  std::string text = sql;
  if (const auto lock = text.find(" FOR UPDATE"); lock != std::string::npos) text.resize(lock);
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v3(db_, text.c_str(), -1, SQLITE_PREPARE_PERSISTENT, &made, nullptr) != SQLITE_OK)
    return error();
  statement = std::make_unique<SqliteStatement>(*this, made);
  return statement.get();
}

Result<std::string> page_fault(Database& db, PageCheck check) {
  Query query(db, check == PageCheck::full ? "PRAGMA integrity_check(1)" : "PRAGMA quick_check(1)");
  const auto checked = query.row();
  if (!checked && checked.error().code == Code::internal) return checked.error().what;
  if (!checked) return tl::make_unexpected(checked.error());
  return query.text(0) == "ok" ? std::string() : query.text(0);
}

}  // namespace vacuform
