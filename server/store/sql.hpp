// Rows in a database of any kind, as the store needs them. The headers of SQLite and libpq stay in one .cpp each.
//
// Statements are written in the SQL that SQLite and PostgreSQL share, with three differences that each database settles
// when it prepares a statement:
//  - arguments are `?` or `?1`;
//  - `INDEXED BY name` is for SQLite alone, which would otherwise scan a queue with another index;
//  - `FOR UPDATE`, at the end, is for PostgreSQL alone: SQLite runs one transaction at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

// A prepared statement of one connection.
class Statement {
 public:
  virtual ~Statement() = default;
  // The arguments, from 1; those that are not bound are NULL.
  virtual void bind(int index, std::string_view value) = 0;
  virtual void bind(int index, std::int64_t value) = 0;
  virtual void bind(int index, double value) = 0;
  // Announces that the rows will be read. PostgreSQL brings the rows of all announced statements in one trip, when the first
  // of them is read. Until then, change nothing that they read.
  virtual void send() {}
  // Steps to the next row; false after the last.
  virtual Result<bool> step() = 0;
  // Runs a statement without rows. In a transaction its error may be that of a later statement, or of the commit.
  virtual Result<void> run() {
    VACUFORM_CHECK(step());
    return {};
  }
  // Forgets the arguments and the rows.
  virtual void reset() = 0;
  // The columns of the row, from 0. NULL reads as 0 or an empty text.
  virtual bool null(int column) const = 0;
  virtual std::int64_t integer(int column) const = 0;
  virtual double real(int column) const = 0;
  virtual std::string text(int column) const = 0;
};

// A connection. One thread at a time. Errors of everything: disk_full, unavailable, corrupt_file.
class Database {
 public:
  Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  virtual ~Database() = default;

  // One or several statements without arguments and results.
  virtual Result<void> execute(const std::string& sql) = 0;
  // Statements live as long as the connection; `sql` lives as long as the program, and its address identifies it.
  virtual Result<Statement*> prepared(const char* sql) = 0;
  // Within a transaction: other transactions that name the same subject wait until this one has ended.
  virtual Result<void> take_turns(const std::string& subject) = 0;
};

// One use of a prepared statement: the arguments in, in the order of the question marks, and the rows out. A statement has
// one use at a time.
class Query {
 public:
  template <class... Arguments>
  Query(Database& db, const char* sql, const Arguments&... arguments) : prepared_(db.prepared(sql)) {
    int index = 0;
    if (prepared_) (bind(++index, arguments), ...);
  }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
  ~Query() {
    if (prepared_) (*prepared_)->reset();
  }

  // As Statement::send().
  void send() {
    if (prepared_) (*prepared_)->send();
  }
  // Steps to the next row; false after the last.
  Result<bool> row() {
    if (!prepared_) return tl::make_unexpected(prepared_.error());
    return (*prepared_)->step();
  }
  // For statements that give no rows.
  Result<void> run() {
    if (!prepared_) return tl::make_unexpected(prepared_.error());
    return (*prepared_)->run();
  }

  // The columns of the row, from 0.
  bool null(int column) const { return (*prepared_)->null(column); }
  std::int64_t integer(int column) const { return (*prepared_)->integer(column); }
  double real(int column) const { return (*prepared_)->real(column); }
  std::string text(int column) const { return (*prepared_)->text(column); }

 private:
  void bind(int index, std::string_view value) { (*prepared_)->bind(index, value); }
  void bind(int index, const std::string& value) { (*prepared_)->bind(index, std::string_view(value)); }
  void bind(int index, const char* value) { (*prepared_)->bind(index, std::string_view(value)); }
  void bind(int index, std::int64_t value) { (*prepared_)->bind(index, value); }
  void bind(int index, std::uint64_t value) { (*prepared_)->bind(index, static_cast<std::int64_t>(value)); }
  void bind(int index, int value) { (*prepared_)->bind(index, static_cast<std::int64_t>(value)); }
  void bind(int index, double value) { (*prepared_)->bind(index, value); }
  template <class T>
  void bind(int index, const std::optional<T>& value) {  // none is NULL
    if (value) bind(index, *value);
  }

  Result<Statement*> prepared_;
};

}  // namespace vacuform
