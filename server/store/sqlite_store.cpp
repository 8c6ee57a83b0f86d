#include "server/store/sqlite_store.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/store/file_blobs.hpp"
#include "server/store/schema.hpp"

namespace vacuform {

Result<void> SqliteStore::open(const std::filesystem::path& data) {
  VACUFORM_CHECK(db_.open((data / "jobs.sqlite").string()));
  // A job's row is some 4 KB with its settings: the pages of ten thousand fit into 64 MiB of cache, not into SQLite's 2.
  VACUFORM_CHECK(
      db_.execute("PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
                  "PRAGMA foreign_keys=ON; PRAGMA trusted_schema=OFF;"
                  "PRAGMA cache_size=-65536"));
  VACUFORM_CHECK(bring_up_to_date(db_));
  VACUFORM_CHECK(sync_directory(data));
  {
    Query newest(db_, "SELECT max(created) FROM job");
    VACUFORM_TRY(found, newest.row());
    if (found) last_id_time_ = newest.integer(0);
  }
  opened_ = options_.clock();
  opened_elapsed_ = options_.elapsed();
  {
    Query running(db_, "SELECT id FROM job WHERE state IN ('running','cancelling')");
    for (;;) {
      VACUFORM_TRY(more, running.row());
      if (!more) break;
      leases_[running.text(0)] = opened_elapsed_ + options_.lease;
    }
  }
  // The clock may have been set back since these were written.
  const Millis longest = opened_ + longest_rest;
  VACUFORM_CHECK(
      Query(db_, "UPDATE job SET not_before=?1 WHERE state='queued' AND not_before>?1", longest).run());
  // A crash may have come between a file and the row that names it.
  return blobs_->sweep([&](const std::string& sha256) { return named(sha256); });
}

void SqliteStore::transaction_ended(bool committed) {
  if (!committed) {
    doubtful_ = true;
    commits_before_doubt_ = db_.commits();
  } else {
    if (db_.commits() != commits_before_doubt_) doubtful_ = false;
    if (options_.job_ended)
      for (const Job& job : ended_jobs_) options_.job_ended(job);
    news_.tell(changed_);
  }
  ended_jobs_.clear();
  changed_.clear();
}

// A full disk: the reserve gives some room, and so does SQLite's log, which begins again from its start.
void SqliteStore::make_room() {
  room_->give_up();
  (void)db_.execute("PRAGMA wal_checkpoint(RESTART)");
}

void SqliteStore::collect_garbage() {
  std::vector<std::string> garbage;
  {
    const std::lock_guard hold(commits_.lock());
    if (doubtful_ || backups_ > 0) return;
    garbage.swap(garbage_);
  }
  for (const std::string& sha256 : garbage)
    blobs_->collect(sha256, [this](const std::string& blob) { return wanted(blob); });
}

Result<bool> SqliteStore::wanted(const std::string& sha256) {
  const std::lock_guard hold(commits_.lock());
  if (!doubtful_ && backups_ == 0) return named(sha256);
  maybe_garbage(sha256);
  return true;
}

Result<Blob> SqliteStore::Stored::add(std::variant<Upload, Blob>& file) {
  if (const auto* blob = std::get_if<Blob>(&file)) {
    pins.emplace_back(store.blobs_->pin(blob->sha256), blob->sha256);
    return *blob;
  }
  auto& upload = std::get<Upload>(file);
  VACUFORM_TRY(pin, store.blobs_->put(upload));
  pins.emplace_back(std::move(pin), upload.digest().sha256);
  return upload.digest();
}

SqliteStore::Stored::~Stored() {
  if (named) return;
  for (auto& [pin, sha256] : pins) {
    pin.release();
    const std::lock_guard hold(store.commits_.lock());
    store.maybe_garbage(sha256);
  }
}

Result<std::vector<Expired>> SqliteStore::expire() {
  const Deletion deletion(*this);
  auto expired = write([&] { return expire_now(); });
  blobs_->collect_again([this](const std::string& blob) { return wanted(blob); });
  room_->restore();
  return expired;
}

Result<bool> SqliteStore::named(const std::string& sha256) {
  Query query(
      db_,
      "SELECT 1 FROM input WHERE blob=?1 UNION ALL SELECT 1 FROM artifact WHERE blob=?1"
      " UNION ALL SELECT 1 FROM upload WHERE blob=?1 UNION ALL SELECT 1 FROM scan WHERE blob=?1 LIMIT 1",
      sha256);
  return query.row();
}

bool has_store(const std::filesystem::path& data) {
  std::error_code error;
  return std::filesystem::exists(data / "jobs.sqlite", error);
}

tl::unexpected<Error> no_store(const std::filesystem::path& data) {
  return fail(Code::not_found, "there is no job store in this folder", data.string(),
              "give the data folder of the service with --data");
}

Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options) {
  VACUFORM_CHECK(make_directory(data));
  File lock(::open((data / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
  if (!lock.is_open())
    return fail(errno == ENOSPC ? Code::disk_full : Code::unavailable, "the data folder cannot be written to",
                data.string(), "check that the server may write there, and that its disk has room");
  if (::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0)
    return fail(Code::unavailable, "another server uses this data folder", data.string(),
                "stop it, or give another folder with --data");
  auto room = DiskRoom::open(data, options.kept_free);
  VACUFORM_TRY(blobs, FileBlobs::open(data, room));
  auto store =
      std::make_unique<SqliteStore>(std::move(options), std::move(room), std::move(blobs), std::move(lock));
  VACUFORM_CHECK(store->open(data));
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace vacuform
