// What an administrator sees of the store.
#include "server/store/schema.hpp"
#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

constexpr std::string_view last_backup = "last_backup";

}  // namespace

Result<StoreStatus> SqliteStore::status() {
  const std::lock_guard hold(commits_.lock());
  StoreStatus status;
  status.schema = newest_schema;
  status.disk = room_->space();
  VACUFORM_TRY(counts, counts_now());
  status.counts = counts;
  Query oldest(db_, "SELECT created FROM job WHERE state='queued' ORDER BY id LIMIT 1");
  VACUFORM_TRY(waits, oldest.row());
  if (waits) status.oldest_queued = oldest.integer(0);
  Query backup(db_, "SELECT value FROM remembered WHERE name=?", last_backup);
  VACUFORM_TRY(made, backup.row());
  if (made) status.last_backup = backup.integer(0);
  const Millis elapsed = options_.elapsed(), now = options_.clock();
  Query running(
      db_, "SELECT coalesce(worker, ''), id FROM job WHERE state IN ('running','cancelling') ORDER BY id");
  for (;;) {
    VACUFORM_TRY(more, running.row());
    if (!more) return status;
    const auto lease = leases_.find(running.text(1));
    if (lease == leases_.end() || lease->second <= elapsed) continue;  // its worker is lost
    status.working.push_back(
        {running.text(0), running.text(1), now - (elapsed + options_.lease - lease->second)});
  }
}

Result<void> SqliteStore::remember_backup() {
  return write([&] {
    return Query(db_, "INSERT OR REPLACE INTO remembered(name, value) VALUES(?,?)", last_backup,
                 options_.clock())
        .run();
  });
}

}  // namespace vacuform
