#include "server/store/sql/postgres_store.hpp"

#include <algorithm>
#include <charconv>
#include <thread>

#include "api/base/secrets.hpp"
#include "server/store/blobs/s3/s3_address.hpp"
#include "server/store/folder_mark.hpp"
#include "server/store/postgres/postgres_schema.hpp"
#include "server/store/sqlite/sqlite.hpp"
#include "server/store/sqlite/sqlite_schema.hpp"

namespace vacuform {

namespace {

constexpr int most_tries = 4;
constexpr std::chrono::seconds poll_for_changes(2);

// Longer with every try, and random, so that two changes that met do not meet again.
void pause_before(int attempt) {
  const auto chance = static_cast<int>(std::stoul(random_hex(2), nullptr, 16) % 50);
  std::this_thread::sleep_for(std::chrono::milliseconds((20 << attempt) + chance));
}

// The clock of the database in milliseconds, unless the argument names a time.
#define VACUFORM_NOW \
  "coalesce(CAST(?1 AS bigint), CAST(extract(epoch FROM clock_timestamp())*1000 AS bigint))"

constexpr const char* time_now = "SELECT " VACUFORM_NOW;
constexpr const char* renew_lease = "INSERT INTO lease(job, ends) VALUES(?3, " VACUFORM_NOW
                                    "+?2) ON CONFLICT(job) DO UPDATE SET ends=excluded.ends";
// Leases that are to end at once have the end 0, which no hold delays.
constexpr const char* leases_over =
    "SELECT job FROM lease WHERE ends=0 OR (CAST(?2 AS integer)=0 AND ends<=" VACUFORM_NOW ")";
constexpr const char* locked_leases_over =
    "SELECT lease.job FROM lease JOIN job ON job.id=lease.job WHERE lease.ends=0 OR (CAST(?2 AS integer)=0"
    " AND lease.ends<=" VACUFORM_NOW ") FOR UPDATE SKIP LOCKED";
constexpr const char* leases_left = "SELECT job, ends-" VACUFORM_NOW " FROM lease WHERE ends>" VACUFORM_NOW;

// A raised job, or the first of the owner whose turn it is. Passes over jobs that rest or are just being leased. With the
// lock it also passes over owners whose counts another transaction changes; without it, it waits for that transaction.
#define VACUFORM_MAY_RUN "(not_before IS NULL OR not_before<=" VACUFORM_NOW ")"
#define VACUFORM_NEXT_JOB(lock)                                                                             \
  "SELECT id FROM (SELECT id FROM job WHERE state='queued' AND priority>0 AND " VACUFORM_MAY_RUN            \
  " ORDER BY priority DESC, id LIMIT 1 FOR UPDATE SKIP LOCKED) AS raised"                                   \
  " UNION ALL"                                                                                              \
  " SELECT own.id FROM (SELECT owner FROM submitter WHERE queued>0 ORDER BY running, served, owner" lock    \
  ") AS turn"                                                                                               \
  " CROSS JOIN LATERAL (SELECT id FROM job WHERE state='queued' AND owner=turn.owner AND " VACUFORM_MAY_RUN \
  " ORDER BY priority DESC, id LIMIT 1 FOR UPDATE SKIP LOCKED) AS own"                                      \
  " LIMIT 1"
constexpr const char* next_job = VACUFORM_NEXT_JOB("");
constexpr const char* next_job_without_waiting = VACUFORM_NEXT_JOB(" FOR UPDATE SKIP LOCKED");

#undef VACUFORM_NEXT_JOB
#undef VACUFORM_MAY_RUN
#undef VACUFORM_NOW

constexpr int rows_at_once = 1000;

void bind_value(Statement& target, const CopiedTable& table, std::size_t column, const std::string& value) {
  const auto index = static_cast<int>(column) + 1;
  double number = 0;
  if (table.real != index) return target.bind(index, std::string_view(value));
  std::from_chars(value.data(), value.data() + value.size(), number);  // SQLite would round it another way
  target.bind(index, number);
}

// One table of a copy, `rows_at_once` at a time; `copied` is called in between.
Result<void> copy_table(PostgresConnection& from, const CopiedTable& table, Statement* target,
                        const std::function<Result<void>()>& copied) {
  const std::string name = std::string("copied_") + table.name;
  const std::string fetch = "FETCH " + std::to_string(rows_at_once) + " FROM " + name;
  VACUFORM_CHECK(
      from.execute("DECLARE " + name + " CURSOR FOR SELECT " + table.columns + " FROM " + table.name));
  for (;;) {
    VACUFORM_TRY(rows, from.rows_of(fetch));
    if (rows.empty()) return {};
    for (const auto& row : rows) {
      for (std::size_t i = 0; i < row.size(); ++i)
        if (row[i]) bind_value(*target, table, i, *row[i]);
      const auto stepped = target->step();
      target->reset();
      if (!stepped) return tl::make_unexpected(stepped.error());
    }
    if (rows.size() == rows_at_once) VACUFORM_CHECK(copied());
  }
}

}  // namespace

PostgresStore::PostgresStore(StoreOptions options, std::shared_ptr<DiskRoom> room,
                             std::unique_ptr<BlobStore> blobs, File lock)
    : SqlStore(std::move(options), std::move(room), std::move(blobs), poll_for_changes),
      lock_(std::move(lock)),
      pool_(options_.database) {
  pool_.on_recovery([this] { leases_.hold(); });
}

Result<void> PostgresStore::open(const std::filesystem::path& data) {
  leases_.hold();
  for (int attempt = 1;; ++attempt) {
    bool again = false;
    const auto changed = pool_.with([&](PostgresConnection& connection) {
      auto result = bring_postgres_up_to_date(connection);
      again = connection.may_try_again();
      return result;
    });
    if (changed) break;
    if (!again || attempt == most_tries) return changed;
    pause_before(attempt);
  }
  VACUFORM_CHECK(match_folder(data, postgresql_name));
  const auto looked = read_rows([&](Database& db) -> Result<void> {
    Query newest(db, "SELECT max(created) FROM job");
    VACUFORM_TRY(found, newest.row());
    if (found) ids_after(newest.integer(0));
    return {};
  });
  VACUFORM_CHECK(looked);
  VACUFORM_CHECK(begin_blobs());
  announcements_ = std::make_unique<PostgresNotifications>(pool_, notifications());
  return {};
}

Result<void> PostgresStore::read_rows(const Look& look) {
  for (int attempt = 1;; ++attempt) {
    bool again = false;
    const auto looked = pool_.with([&](PostgresConnection& connection) {
      auto result = look(connection);
      again = connection.may_try_again();
      return result;
    });
    if (looked || !again || attempt == most_tries) return looked;
    pause_before(attempt);
  }
}

Result<PostgresStore::Outcome> PostgresStore::change_once(PostgresConnection& connection,
                                                          const Change& change) {
  connection.begin();
  const bool wanted = change(connection);
  if (!wanted || !connection.is_there() || connection.failed()) {
    connection.roll_back();
    if (connection.may_try_again()) return Outcome::again;
    if (!wanted) return Outcome::refused;
    return fail(Code::unavailable, "the database refused a part of a change", {},
                "see the log of the database");
  }
  const auto committed = connection.commit();
  if (committed && !connection.warned()) return Outcome::done;
  if (!committed && !connection.lost()) {
    connection.roll_back();
    if (connection.may_try_again()) return Outcome::again;
    return tl::make_unexpected(committed.error());
  }
  return fail(Code::unavailable, "the database did not confirm a change, which may be made all the same", {},
              "repeat the request with the same idempotency key or lease");
}

Result<void> PostgresStore::transaction(const Change& change) {
  for (int attempt = 1;; ++attempt) {
    Outcome outcome = Outcome::refused;
    const auto used = pool_.with([&](PostgresConnection& connection) -> Result<void> {
      VACUFORM_TRY(one, change_once(connection, change));
      outcome = one;
      return {};
    });
    VACUFORM_CHECK(used);
    if (outcome != Outcome::again) return {};
    if (attempt == most_tries)
      return fail(Code::unavailable, "the database could not make a change", {}, "try again later");
    pause_before(attempt);
  }
}

std::int64_t PostgresStore::schema_version() const { return newest_postgres_schema; }

// Both views hide columns of others from users without the right to read statistics.
Result<void> PostgresStore::describe(Database& db, StoreStatus& status) {
  Query query(db,
              "SELECT current_setting('synchronous_standby_names')<>''"
              " AND current_setting('synchronous_commit') IN ('on','remote_apply')"
              " AND EXISTS(SELECT 1 FROM pg_stat_replication WHERE sync_state IN ('sync','quorum'))");
  VACUFORM_CHECK(query.row());
  if (query.text(0) == "t") status.durability = "synchronous";
  Query oldest(
      db,
      "SELECT coalesce(max(extract(epoch FROM clock_timestamp()-xact_start)), 0) FROM pg_stat_activity"
      " WHERE backend_xmin IS NOT NULL AND datname=current_database() AND pid<>pg_backend_pid()");
  VACUFORM_CHECK(oldest.row());
  status.oldest_transaction_seconds = oldest.real(0);
  return {};
}

Result<void> PostgresStore::copy_rows(const std::filesystem::path& file, const std::function<bool()>& going) {
  std::vector<std::string> insertions;  // outlive the statements
  for (const CopiedTable& table : copied_tables()) insertions.push_back(insertion(table));
  SqliteDatabase copy;
  VACUFORM_CHECK(copy.open(file.string()));
  VACUFORM_CHECK(bring_up_to_date(copy));
  VACUFORM_CHECK(copy.execute("BEGIN"));
  const auto go_on = [&]() -> Result<void> {
    if (going()) return {};
    return fail(Code::cancelled, "the copy was cancelled");
  };
  const auto all = pool_.with([&](PostgresConnection& connection) -> Result<void> {
    VACUFORM_CHECK(connection.execute("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"));
    Result<void> copied;
    for (std::size_t i = 0; copied && i < insertions.size(); ++i) {
      VACUFORM_TRY(target, copy.prepared(insertions[i].c_str()));
      copied = copy_table(connection, copied_tables()[i], target, go_on);
    }
    const auto ended = connection.execute("ROLLBACK");
    return copied ? ended : copied;
  });
  VACUFORM_CHECK(all);
  VACUFORM_CHECK(go_on());
  return copy.execute("COMMIT");
}

bool PostgresStore::Leases::surely_none_over() const { return elapsed() < none_until_; }

void PostgresStore::Leases::hold() { held_until_ = elapsed() + options_.lease; }

std::optional<Millis> PostgresStore::Leases::set_time() const {
  if (options_.elapsed) return options_.elapsed();
  return std::nullopt;
}

Result<Millis> PostgresStore::Leases::now(Database& db) {
  if (const auto time = set_time()) return *time;
  Query query(db, time_now, set_time());
  VACUFORM_CHECK(query.row());
  return query.integer(0);
}

Result<std::optional<std::string>> PostgresStore::next_queued(Database& db) {
  for (const char* sql : {next_job_without_waiting, next_job}) {
    Query next(db, sql, leases_.set_time());
    VACUFORM_TRY(found, next.row());
    if (found) return std::optional(next.text(0));
  }
  return std::optional<std::string>();
}

Result<void> PostgresStore::Leases::renew(Database& db, const std::string& job) {
  return Query(db, renew_lease, set_time(), options_.lease, job).run();
}

Result<void> PostgresStore::Leases::end(Database& db, const std::string& job) {
  none_until_ = 0;
  return Query(db, "UPDATE lease SET ends=0 WHERE job=?", job).run();
}

Result<void> PostgresStore::Leases::forget(Database& db, const std::string& job) {
  return Query(db, "DELETE FROM lease WHERE job=?", job).run();
}

Result<std::vector<std::string>> PostgresStore::Leases::over(Database& db, bool lock) {
  const Millis asked = elapsed();
  const int held = asked < held_until_ ? 1 : 0;
  Query query(db, lock ? locked_leases_over : leases_over, set_time(), held);
  std::vector<std::string> jobs;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    jobs.push_back(query.text(0));
  }
  if (jobs.empty()) none_until_ = asked + 200;
  return jobs;
}

Result<std::vector<LeaseTimes::Current>> PostgresStore::Leases::current(Database& db) {
  const Millis now = options_.clock();
  Query query(db, leases_left, set_time());
  std::vector<Current> leases;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return leases;
    leases.push_back({query.text(0), now - (options_.lease - query.integer(1))});
  }
}

Result<std::unique_ptr<SqlStore>> open_postgres_store(const std::filesystem::path& data,
                                                      StoreOptions options) {
  VACUFORM_CHECK(check_database(options.database));
  VACUFORM_TRY(lock, lock_data_folder(data));
  auto room = DiskRoom::open(data, options.kept_free);
  VACUFORM_TRY(blobs, open_blobs(data, options, room));
  auto store =
      std::make_unique<PostgresStore>(std::move(options), std::move(room), std::move(blobs), std::move(lock));
  VACUFORM_CHECK(store->open(data));
  return std::unique_ptr<SqlStore>(std::move(store));
}

}  // namespace vacuform
