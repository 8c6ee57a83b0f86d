// A connection to PostgreSQL, and a pool of them. libpq's own header stays in postgres.cpp.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/store/sql.hpp"

struct pg_conn;
struct pg_result;

namespace vacuform {

struct FreePgResult {
  void operator()(pg_result* result) const;
};
using PgResult = std::unique_ptr<pg_result, FreePgResult>;

class PostgresStatement;

// A statement in the shared SQL (sql.hpp) as PostgreSQL reads it.
std::string postgres_sql(std::string_view sql);

class PostgresConnection : public Database {
 public:
  // Errors: unavailable. The message names neither password nor address.
  static Result<std::unique_ptr<PostgresConnection>> open(const std::string& url);
  ~PostgresConnection() override;

  Result<void> execute(const std::string& sql) override;
  Result<Statement*> prepared(const char* sql) override;
  Result<void> take_turns(const std::string& subject) override;

  // A transaction. Its statements without rows, and those that Query::send() names, are only sent (libpq's pipeline
  // mode): their answers, and that of BEGIN, arrive when rows are asked for, or with that of the commit, so that one trip
  // over the network serves several statements. After an error PostgreSQL runs none of the others.
  void begin();
  // False if the connection was lost before begin(), or a statement failed. Before the first answer it waits for one: a
  // commit over a connection that was lost long ago would look as if it may have happened.
  bool is_there() { return answered_ || answers().has_value(); }
  Result<void> commit();
  void roll_back();

  // Reads the answers of all that was sent, if any. Errors: the first of theirs.
  Result<void> answers();

  // All rows of a statement without arguments.
  using Row = std::vector<std::optional<std::string>>;
  Result<std::vector<Row>> rows_of(const std::string& sql);

  // Of the statements since start_over(): whether one has failed, and whether the transaction may succeed if it is tried
  // again: two changes met, or the connection was lost before the commit.
  bool failed() const { return failed_; }
  bool may_try_again() const { return may_try_again_; }
  void start_over() { failed_ = may_try_again_ = false; }
  // Whether the connection is lost.
  bool lost() const;
  // Whether the last commit gave a warning. One that the standby has not confirmed in time succeeds with one.
  bool warned() const { return warned_; }

  // Waits for the next notification of LISTEN, until `time` is over or something can be read from `wake`. Errors:
  // unavailable, if the connection is lost.
  Result<std::optional<std::string>> notification(std::chrono::milliseconds time, int wake);

 private:
  friend class PostgresStatement;
  explicit PostgresConnection(pg_conn* connection);
  tl::unexpected<Error> error(const char* state);
  tl::unexpected<Error> failure(const pg_result* result);
  // Sends a statement whose answer is read later, and is given to `reader` if there is one.
  Result<void> send(const std::function<int()>& statement, PostgresStatement* reader = nullptr);
  // The reader does not want its answer any more.
  void forget(PostgresStatement* reader);

  static constexpr std::size_t most_sent = 64;  // so that neither side waits for the other to read

  pg_conn* connection_;
  bool failed_ = false, may_try_again_ = false, warned_ = false;
  bool in_transaction_ = false, answered_ = false;  // a statement of the transaction has been answered
  std::vector<PostgresStatement*> sent_;            // whose answers have not been read
  std::unordered_map<const char*, std::unique_ptr<PostgresStatement>> statements_;
};

// From any thread. Connections are opened when they are needed, and stay.
class PostgresPool {
 public:
  static constexpr std::size_t most_connections = 16;

  explicit PostgresPool(std::string url) : url_(std::move(url)) {}
  // Called when a connection is opened after one was lost: until then anything may have happened.
  void on_recovery(std::function<void()> recovered) { recovered_ = std::move(recovered); }

  // Calls `use` with a connection that nobody else uses. Waits for one at most ten seconds. Errors: unavailable, and those
  // of `use`.
  Result<void> with(const std::function<Result<void>(PostgresConnection&)>& use);
  const std::string& url() const { return url_; }

 private:
  Result<std::unique_ptr<PostgresConnection>> take();
  void give_back(std::unique_ptr<PostgresConnection> connection);

  const std::string url_;
  std::function<void()> recovered_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::vector<std::unique_ptr<PostgresConnection>> idle_;
  std::size_t used_ = 0;
  bool was_lost_ = false;
};

}  // namespace vacuform
