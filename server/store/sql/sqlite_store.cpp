#include "server/store/sql/sqlite_store.hpp"

#include <limits>

#include "server/store/blobs/s3/s3_address.hpp"
#include "server/store/folder_mark.hpp"
#include "server/store/sql/postgres_store.hpp"
#include "server/store/sqlite/rows_file.hpp"
#include "server/store/sqlite/sqlite_schema.hpp"

namespace vacuform {

Result<void> SqliteStore::open(const std::filesystem::path& data) {
  auto opened = open_rows(data);
  // What is a fault of the server while it serves is that of the file here.
  if (!opened && opened.error().fix == damage_fix) opened.error().code = Code::corrupt_file;
  return opened;
}

Result<void> SqliteStore::open_rows(const std::filesystem::path& data) {
  VACUFORM_CHECK(db_.open((data / "jobs.sqlite").string()));
  // A job's row is some 4 KB with its settings: the pages of ten thousand fit into 64 MiB of cache, not into SQLite's 2.
  // temp_store: what undoes a change stays in memory; otherwise SQLite writes it to a file in each transaction.
  VACUFORM_CHECK(db_.execute(
      "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
      "PRAGMA foreign_keys=ON; PRAGMA secure_delete=ON; PRAGMA trusted_schema=OFF; PRAGMA temp_store=MEMORY;"
      "PRAGMA cache_size=-65536"));
  {
    VACUFORM_TRY(fault, vacuform::page_fault(db_, PageCheck::quick));
    if (!fault.empty())
      return fail(Code::corrupt_file, "the job store is damaged: " + fault, "jobs.sqlite", damage_fix);
  }
  VACUFORM_CHECK(bring_up_to_date(db_));
  VACUFORM_CHECK(sync_directory(data));
  VACUFORM_CHECK(match_folder(data, sqlite_name));
  {
    Query newest(db_, "SELECT max(created) FROM job");
    VACUFORM_TRY(found, newest.row());
    if (found) ids_after(newest.integer(0));
  }
  VACUFORM_CHECK(leases_.open(db_));
  return begin_blobs();
}

Result<void> SqliteStore::read_rows(const Look& look) {
  const std::lock_guard hold(commits_.lock());
  return look(db_);
}

Result<void> SqliteStore::transaction(const Change& change) {
  return commits_.run([&] { return change(db_); });
}

Result<void> SqliteStore::copy_rows(const std::filesystem::path& file, const std::function<bool()>& going) {
  std::unique_lock lock(commits_.lock());
  return db_.copy_to(file.string(), [&] {
    lock.unlock();
    const bool go_on = going();
    lock.lock();
    return go_on;
  });
}

// A copy is checked, since a check of the database itself would stop all requests.
Result<std::string> SqliteStore::page_fault(const std::function<bool()>& going) {
  RowsFile copy(temporary_path());
  const auto copied = copy_rows(copy.path(), going);
  if (!copied && copied.error().code == Code::internal) return copied.error().what;
  VACUFORM_CHECK(copied);
  VACUFORM_CHECK(copy.open());
  return vacuform::page_fault(copy.db(), PageCheck::full);
}

// SQLite overwrites the pages of deleted rows, but its log has them until it begins again.
void SqliteStore::forget_deleted() {
  const std::lock_guard hold(commits_.lock());
  (void)db_.execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

void SqliteStore::transaction_ended(bool committed) {
  if (!committed) {
    doubtful_ = true;
    commits_before_doubt_ = db_.commits();
  } else if (db_.commits() != commits_before_doubt_) {
    doubtful_ = false;
  }
}

std::int64_t SqliteStore::schema_version() const { return newest_schema; }

// A full disk: the reserve gives some room, and so does SQLite's log, which begins again from its start.
void SqliteStore::make_room() {
  room_->give_up();
  (void)db_.execute("PRAGMA wal_checkpoint(RESTART)");
}

Result<std::optional<std::string>> SqliteStore::next_queued(Database& db) {
  VACUFORM_TRY(now, leases_.now(db));
  Query raised(db,
               "SELECT id FROM job INDEXED BY job_raised WHERE state='queued' AND priority>0"
               " AND (not_before IS NULL OR not_before<=?) ORDER BY priority DESC, id LIMIT 1",
               now);
  VACUFORM_TRY(found_raised, raised.row());
  if (found_raised) return std::optional(raised.text(0));
  Query turns(db, "SELECT owner FROM submitter WHERE queued>0 ORDER BY running, served, owner");
  for (;;) {
    VACUFORM_TRY(more, turns.row());
    if (!more) return std::optional<std::string>();
    Query own(db,
              "SELECT id FROM job WHERE state='queued' AND owner=? AND (not_before IS NULL OR not_before<=?)"
              " ORDER BY priority DESC, id LIMIT 1",
              turns.text(0), now);
    VACUFORM_TRY(found, own.row());
    if (found) return std::optional(own.text(0));  // otherwise all its jobs are resting
  }
}

Result<void> SqliteStore::Leases::open(Database& db) {
  opened_ = options_.clock();
  opened_elapsed_ = options_.elapsed();
  Query running(db, "SELECT id FROM job WHERE state IN ('running','cancelling')");
  for (;;) {
    VACUFORM_TRY(more, running.row());
    if (!more) break;
    set(running.text(0), opened_elapsed_ + options_.lease);
  }
  // The clock may have been set back since these were written.
  const Millis longest = opened_ + longest_rest;
  return Query(db, "UPDATE job SET not_before=?1 WHERE state='queued' AND not_before>?1", longest).run();
}

void SqliteStore::Leases::set(const std::string& job, std::optional<Millis> ends) {
  const std::lock_guard hold(mutex_);
  if (const auto old = ends_.find(job); old != ends_.end()) {
    by_end_.erase({old->second, job});
    ends_.erase(old);
  }
  if (!ends) return;
  ends_[job] = *ends;
  by_end_.insert({*ends, job});
}

Result<void> SqliteStore::Leases::renew(Database&, const std::string& job) {
  set(job, options_.elapsed() + options_.lease);
  return {};
}

Result<void> SqliteStore::Leases::end(Database&, const std::string& job) {
  set(job, std::numeric_limits<Millis>::min());
  return {};
}

Result<void> SqliteStore::Leases::forget(Database&, const std::string& job) {
  set(job, std::nullopt);
  return {};
}

std::vector<std::string> SqliteStore::Leases::all_over() const {
  const Millis now = options_.elapsed();
  const std::lock_guard hold(mutex_);
  std::vector<std::string> jobs;
  for (const auto& [ends, job] : by_end_) {
    if (ends > now) break;
    jobs.push_back(job);
  }
  return jobs;
}

Result<std::vector<LeaseTimes::Current>> SqliteStore::Leases::current(Database&) {
  const Millis elapsed = options_.elapsed(), now = options_.clock();
  std::vector<Current> leases;
  const std::lock_guard hold(mutex_);
  for (const auto& [job, ends] : ends_)
    if (ends > elapsed) leases.push_back({job, now - (elapsed + options_.lease - ends)});
  return leases;
}

bool has_store(const std::filesystem::path& data) {
  std::error_code error;
  const auto mark = read_folder_mark(data);
  return std::filesystem::exists(data / "jobs.sqlite", error) || !mark || !mark->database.empty();
}

tl::unexpected<Error> no_store(const std::filesystem::path& data) {
  return fail(Code::not_found, "there is no job store in this folder", data.string(),
              "give the data folder of the service with --data");
}

// SQLite would make an empty database in the place of one that was lost.
static Result<void> check_sqlite_is_there(const std::filesystem::path& data, bool blobs_are_files) {
  VACUFORM_TRY(mark, read_folder_mark(data));
  if (mark.database == postgresql_name)
    return fail(Code::corrupt_file, "the jobs of this data folder are in PostgreSQL", data.string(),
                "give their database with --store, or another folder with --data");
  std::error_code error;
  if (std::filesystem::exists(data / "jobs.sqlite", error)) return {};
  if (mark.database.empty() && !(blobs_are_files && has_blobs(data))) return {};
  return fail(
      Code::corrupt_file, "the database of this data folder is missing, but not its files",
      (data / "jobs.sqlite").string(),
      "put it back, or restore a backup with vacuform-server restore; vacuform-server adopt begins an "
      "empty one and keeps the files");
}

Result<std::unique_ptr<SqlStore>> open_sql_store(const std::filesystem::path& data, StoreOptions options) {
  if (!options.database.empty()) return open_postgres_store(data, std::move(options));
  if (!options.elapsed) options.elapsed = boot_clock;
  VACUFORM_TRY(lock, lock_data_folder(data));
  if (!options.adopt) VACUFORM_CHECK(check_sqlite_is_there(data, blobs_in_files(options.blobs)));
  auto room = DiskRoom::open(data, options.kept_free);
  VACUFORM_TRY(blobs, open_blobs(data, options, room));
  auto store =
      std::make_unique<SqliteStore>(std::move(options), std::move(room), std::move(blobs), std::move(lock));
  VACUFORM_CHECK(store->open(data));
  return std::unique_ptr<SqlStore>(std::move(store));
}

Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options) {
  VACUFORM_TRY(store, open_sql_store(data, std::move(options)));
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace vacuform
