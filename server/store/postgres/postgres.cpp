#include "server/store/postgres/postgres.hpp"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "server/store/store.hpp"

namespace vacuform {

void FreePgResult::operator()(pg_result* result) const { PQclear(result); }

namespace {

bool succeeded(const PGresult* result) {
  const auto status = PQresultStatus(result);
  return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
}

const char* state_of(const PGresult* result) {
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return state ? state : "";
}

// The first line of the server's message, without the details, which may contain values of rows.
std::string message_of(const PGresult* result) {
  const char* text = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  return text ? text : "the connection was lost";
}

constexpr const char* look_at_database = "check that the database runs and that the server may reach it";

}  // namespace

Result<void> check_database(const std::string& text) {
  if (text.empty()) return {};
  if (text.rfind("postgresql://", 0) != 0 && text.rfind("postgres://", 0) != 0)
    return fail(Code::bad_usage, "the address names no database that this server knows", "--store",
                "give it like postgresql://user@host/database, or leave it out for SQLite");
  // libpq's own message is not shown: it may quote a part of a password.
  PQconninfoOption* options = PQconninfoParse(text.c_str(), nullptr);
  if (!options)
    return fail(Code::bad_usage, "the address of the database cannot be read", "--store",
                "give it like postgresql://user@host/database");
  bool password = false;
  for (const PQconninfoOption* option = options; option->keyword; ++option)
    password = password || (std::strcmp(option->keyword, "password") == 0 && option->val && *option->val);
  PQconninfoFree(options);
  if (password)
    return fail(Code::bad_usage, "the address of the database contains a password", "--store",
                "put the password into a file and add ?passfile=FILE, or into ~/.pgpass");
  return {};
}

std::string postgres_sql(std::string_view sql) {
  std::string text;
  int next = 0;
  for (std::size_t i = 0; i < sql.size(); ++i) {
    if (sql.substr(i).rfind(" INDEXED BY ", 0) == 0) {
      i += std::string_view(" INDEXED BY ").size();
      i = std::min(sql.find(' ', i), sql.size());
    }
    if (i == sql.size()) break;
    text += sql[i] == '?' ? '$' : sql[i];
    if (sql[i] == '?' && (i + 1 == sql.size() || sql[i + 1] < '0' || sql[i + 1] > '9'))
      text += std::to_string(++next);
  }
  return text;
}

class PostgresStatement : public Statement {
 public:
  PostgresStatement(PostgresConnection& connection, std::string name, std::string sql)
      : connection_(connection), name_(std::move(name)), sql_(std::move(sql)) {}

  void bind(int index, std::string_view value) override {
    const auto place = static_cast<std::size_t>(index);
    if (arguments_.size() < place) arguments_.resize(place);
    arguments_[place - 1] = std::string(value);
  }
  void bind(int index, std::int64_t value) override { bind(index, std::string_view(std::to_string(value))); }
  void bind(int index, double value) override {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    bind(index, std::string_view(text, static_cast<std::size_t>(end - text)));
  }
  void send() override {
    if (sent_) return;
    // If this fails, step() tries again and reports it.
    if (prepare()) sent_ = send_for(this).has_value();
  }
  Result<bool> step() override {
    if (!result_) VACUFORM_CHECK(ask());
    return ++row_ < PQntuples(result_.get());
  }
  Result<void> run() override {
    if (!connection_.in_transaction_) return ask();
    VACUFORM_CHECK(prepare());
    return send_for(nullptr);
  }
  void reset() override {
    if (sent_) connection_.forget(this);
    arguments_.clear();
    result_.reset();
    row_ = -1;
    sent_ = false;
  }
  void answer(PgResult result) { result_ = std::move(result); }
  bool null(int column) const override { return PQgetisnull(result_.get(), row_, column) != 0; }
  std::int64_t integer(int column) const override {
    std::int64_t value = 0;
    const std::string_view digits = bytes(column);
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value;
  }
  double real(int column) const override {
    double value = 0;
    const std::string_view digits = bytes(column);
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value;
  }
  std::string text(int column) const override { return std::string(bytes(column)); }

 private:
  std::string_view bytes(int column) const {
    return {PQgetvalue(result_.get(), row_, column),
            static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
  }
  Result<void> prepare() {
    if (prepared_) return {};
    if (!connection_.sent_.empty()) VACUFORM_CHECK(connection_.answers());
    PGconn* const connection = connection_.connection_;
    const PgResult made(PQprepare(connection, name_.c_str(), sql_.c_str(), 0, nullptr));
    if (!succeeded(made.get())) return connection_.failure(made.get());
    prepared_ = true;
    const PgResult described(PQdescribePrepared(connection, name_.c_str()));
    if (!succeeded(described.get())) return connection_.failure(described.get());
    parameters_ = static_cast<std::size_t>(PQnparams(described.get()));
    return {};
  }
  std::vector<const char*> values() {
    arguments_.resize(parameters_);  // the last ones may be NULL
    std::vector<const char*> all;
    for (const auto& argument : arguments_) all.push_back(argument ? argument->c_str() : nullptr);
    return all;
  }
  Result<void> send_for(PostgresStatement* reader) {
    return connection_.send(
        [&] {
          return PQsendQueryPrepared(connection_.connection_, name_.c_str(), static_cast<int>(parameters_),
                                     values().data(), nullptr, nullptr, 0);
        },
        reader);
  }
  Result<void> ask() {
    if (!sent_) VACUFORM_CHECK(prepare());
    if (!sent_ && connection_.sent_.empty()) {
      result_.reset(PQexecPrepared(connection_.connection_, name_.c_str(), static_cast<int>(parameters_),
                                   values().data(), nullptr, nullptr, 0));
      if (!succeeded(result_.get())) return connection_.failure(result_.get());
      return {};
    }
    if (!sent_) VACUFORM_CHECK(send_for(this));
    VACUFORM_CHECK(connection_.answers());
    if (!result_) return connection_.error("25P02");  // a statement before it failed
    return {};
  }

  PostgresConnection& connection_;
  const std::string name_, sql_;
  bool prepared_ = false, sent_ = false;
  std::size_t parameters_ = 0;
  std::vector<std::optional<std::string>> arguments_;
  PgResult result_;
  int row_ = -1;
};

Result<std::unique_ptr<PostgresConnection>> PostgresConnection::open(const std::string& url) {
  // A later word wins: the URL may set what stands before it. Only a server that takes writes is of use.
  const char* const words[] = {"connect_timeout",
                               "keepalives_idle",
                               "tcp_user_timeout",
                               "fallback_application_name",
                               "dbname",
                               "target_session_attrs",
                               nullptr};
  const char* const values[] = {"5", "10", "15000", "vacuform-server", url.c_str(), "read-write", nullptr};
  std::unique_ptr<PostgresConnection> made(new PostgresConnection(PQconnectdbParams(words, values, 1)));
  if (PQstatus(made->connection_) != CONNECTION_OK)
    return fail(Code::unavailable, "the database cannot be reached", {}, look_at_database);
  PQsetNoticeReceiver(
      made->connection_,
      [](void* connection, const PGresult* notice) {
        const char* severity = PQresultErrorField(notice, PG_DIAG_SEVERITY_NONLOCALIZED);
        if (severity && std::strcmp(severity, "WARNING") == 0)
          static_cast<PostgresConnection*>(connection)->warned_ = true;
      },
      made.get());
  // Not among the words of the connection: poolers refuse them there.
  VACUFORM_CHECK(
      made->execute("SET statement_timeout='30s'; SET lock_timeout='10s';"
                    "SET idle_in_transaction_session_timeout='60s'; SET client_min_messages=warning"));
  return made;
}

PostgresConnection::PostgresConnection(pg_conn* connection) : connection_(connection) {}

PostgresConnection::~PostgresConnection() {
  statements_.clear();
  PQfinish(connection_);
}

bool PostgresConnection::lost() const { return PQstatus(connection_) != CONNECTION_OK; }

tl::unexpected<Error> PostgresConnection::error(const char* state) {
  const std::string_view code(state);
  failed_ = true;
  // serialization_failure, deadlock_detected, lock_not_available, unique_violation (another change was first),
  // admin_shutdown, crash_shutdown, cannot_connect_now, read_only_sql_transaction (a standby).
  for (const char* again : {"40001", "40P01", "55P03", "23505", "57P01", "57P02", "57P03", "25006", "25P03"})
    may_try_again_ = may_try_again_ || code == again;
  may_try_again_ = may_try_again_ || lost() || code.substr(0, 2) == "08";
  if (code == "53100")
    return fail(Code::disk_full, "the database has no room", {}, "free some space on its disk and try again");
  return fail(Code::unavailable, "the database cannot be used", {}, look_at_database);
}

tl::unexpected<Error> PostgresConnection::failure(const pg_result* result) {
  auto failure = error(state_of(result));
  failure.value().what += ": " + message_of(result);
  return failure;
}

Result<void> PostgresConnection::execute(const std::string& sql) {
  const PgResult result(PQexec(connection_, sql.c_str()));
  if (!succeeded(result.get())) return failure(result.get());
  return {};
}

void PostgresConnection::begin() {
  in_transaction_ = true;
  answered_ = false;
  (void)send(
      [&] { return PQsendQueryParams(connection_, "BEGIN", 0, nullptr, nullptr, nullptr, nullptr, 0); });
}

Result<void> PostgresConnection::commit() {
  warned_ = false;
  in_transaction_ = false;
  VACUFORM_CHECK(send(
      [&] { return PQsendQueryParams(connection_, "COMMIT", 0, nullptr, nullptr, nullptr, nullptr, 0); }));
  return answers();
}

void PostgresConnection::roll_back() {
  in_transaction_ = false;
  (void)answers();
  (void)execute("ROLLBACK");
}

Result<void> PostgresConnection::send(const std::function<int()>& statement, PostgresStatement* reader) {
  if (sent_.empty()) PQenterPipelineMode(connection_);
  if (statement() == 0) return error("08006");
  sent_.push_back(reader);
  return sent_.size() < most_sent ? Result<void>() : answers();
}

void PostgresConnection::forget(PostgresStatement* reader) {
  std::replace(sent_.begin(), sent_.end(), reader, static_cast<PostgresStatement*>(nullptr));
}

Result<void> PostgresConnection::answers() {
  if (PQpipelineStatus(connection_) == PQ_PIPELINE_OFF) return {};
  PgResult faulty;
  PQpipelineSync(connection_);
  for (PostgresStatement* reader : std::exchange(sent_, {})) {
    while (PgResult result{lost() ? nullptr : PQgetResult(connection_)}) {
      if (!succeeded(result.get())) {
        if (!faulty) faulty = std::move(result);
      } else if (reader) {
        reader->answer(std::move(result));
      }
    }
  }
  if (lost()) return faulty ? failure(faulty.get()) : error("08006");
  PQclear(PQgetResult(connection_));  // of the end of the pipeline
  PQexitPipelineMode(connection_);
  answered_ = true;
  if (faulty) return failure(faulty.get());
  return {};
}

Result<std::vector<PostgresConnection::Row>> PostgresConnection::rows_of(const std::string& sql) {
  const PgResult result(PQexec(connection_, sql.c_str()));
  if (!succeeded(result.get())) return failure(result.get());
  std::vector<Row> rows(static_cast<std::size_t>(PQntuples(result.get())));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (int column = 0; column < PQnfields(result.get()); ++column) {
      const auto number = static_cast<int>(i);
      rows[i].push_back(PQgetisnull(result.get(), number, column)
                            ? std::nullopt
                            : std::optional<std::string>(PQgetvalue(result.get(), number, column)));
    }
  return rows;
}

Result<Statement*> PostgresConnection::prepared(const char* sql) {
  auto& statement = statements_[sql];
  if (!statement)
    statement = std::make_unique<PostgresStatement>(
        *this, std::string("s").append(std::to_string(statements_.size())), postgres_sql(sql));
  return statement.get();
}

Result<void> PostgresConnection::take_turns(const std::string& subject) {
  return Query(*this, "SELECT pg_advisory_xact_lock(hashtextextended(current_schema() || ?, 0))", subject)
      .run();
}

Result<std::optional<std::string>> PostgresConnection::notification(std::chrono::milliseconds time,
                                                                    int wake) {
  const auto until = std::chrono::steady_clock::now() + time;
  for (;;) {
    if (PQconsumeInput(connection_) == 0) return error("08006");
    if (PGnotify* found = PQnotifies(connection_)) {
      std::string payload = found->extra;
      PQfreemem(found);
      return std::optional(std::move(payload));
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0) return std::optional<std::string>();
    pollfd waits[] = {{PQsocket(connection_), POLLIN, 0}, {wake, POLLIN, 0}};
    ::poll(waits, 2, static_cast<int>(left.count()));
    if (waits[1].revents != 0) return std::optional<std::string>();
  }
}

Result<std::unique_ptr<PostgresConnection>> PostgresPool::take() {
  bool was_lost = false;
  {
    std::unique_lock hold(mutex_);
    if (!returned_.wait_for(hold, std::chrono::seconds(10), [&] { return used_ < most_connections; }))
      return fail(Code::unavailable, "every connection to the database is busy", {}, "try again later");
    ++used_;
    was_lost = was_lost_;
    if (!idle_.empty()) {
      auto connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  auto opened = PostgresConnection::open(url_);
  if (opened && was_lost && recovered_) recovered_();  // before its first use
  const std::lock_guard hold(mutex_);
  was_lost_ = !opened;
  if (opened) return opened;
  --used_;
  returned_.notify_one();
  return opened;
}

void PostgresPool::give_back(std::unique_ptr<PostgresConnection> connection) {
  const std::lock_guard hold(mutex_);
  --used_;
  if (connection->lost()) {
    was_lost_ = true;
    idle_.clear();  // they were opened before, and are likely to be lost, too
  } else {
    idle_.push_back(std::move(connection));
  }
  returned_.notify_one();
}

Result<void> PostgresPool::with(const std::function<Result<void>(PostgresConnection&)>& use) {
  VACUFORM_TRY(connection, take());
  connection->start_over();
  auto result = use(*connection);
  (void)connection->answers();  // of rows that nobody wanted
  give_back(std::move(connection));
  return result;
}

}  // namespace vacuform
