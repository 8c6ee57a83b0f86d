#include "server/store/sqlite_store.hpp"

#include <fcntl.h>
#include <sys/file.h>

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
  VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_ends=? WHERE state IN ('running','cancelling')",
                       options_.clock() + options_.lease)
                     .run());
  // A crash may have come between a file and the row that names it.
  return blobs_.sweep([&](const std::string& sha256) { return named(sha256).value_or(true); });
}

void SqliteStore::committed() {
  if (backups_ == 0) {
    for (const auto& sha256 : garbage_)
      if (const auto used = named(sha256); used && !*used) {
        blobs_.remove(sha256);
        if (options_.blob_gone) options_.blob_gone(sha256);
      }
    garbage_.clear();
  }
  news_.tell(changed_);
  changed_.clear();
}

Result<bool> SqliteStore::named(const std::string& sha256) {
  Query query(
      db_,
      "SELECT 1 FROM input WHERE blob=?1 UNION ALL SELECT 1 FROM artifact WHERE blob=?1"
      " UNION ALL SELECT 1 FROM upload WHERE blob=?1 UNION ALL SELECT 1 FROM scan WHERE blob=?1 LIMIT 1",
      sha256);
  return query.row();
}

Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options) {
  VACUFORM_CHECK(make_directory(data));
  File lock(::open((data / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
  if (!lock.is_open() || ::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0)
    return fail(Code::unavailable, "another server uses this data folder", data.string(),
                "stop it, or give another folder with --data");
  VACUFORM_TRY(blobs, Blobs::open(data));
  auto store = std::make_unique<SqliteStore>(std::move(options), std::move(blobs), std::move(lock));
  VACUFORM_CHECK(store->open(data));
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace vacuform
