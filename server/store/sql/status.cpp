// What an administrator sees of the store.
#include <map>

#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

Result<std::optional<Millis>> last_time(Database& db, std::string_view event) {
  Query query(db, "SELECT value FROM remembered WHERE name=?", event);
  VACUFORM_TRY(found, query.row());
  return found ? std::optional<Millis>(query.integer(0)) : std::nullopt;
}

}  // namespace

Result<JobCounts> SqlStore::counts(Database& db) {
  JobCounts counts{};
  Query query(db, "SELECT state, count(*) FROM job GROUP BY state");
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    if (const auto state = job_state_from(query.text(0)))
      counts[static_cast<std::size_t>(*state)] = query.integer(1);
  }
  const auto count = [&](JobState state) -> std::int64_t& { return counts[static_cast<std::size_t>(state)]; };
  VACUFORM_TRY(over, lease_times().over(db, false));
  for (const std::string& id : over) {
    const auto job = find(db, id, Detail::brief);
    if (!job) continue;
    if (job->state == JobState::running) --count(JobState::running), ++count(JobState::queued);
    if (job->state == JobState::cancelling) --count(JobState::cancelling), ++count(JobState::cancelled);
  }
  return counts;
}

Result<StoreStatus> SqlStore::status() {
  return read([&](Database& db) -> Result<StoreStatus> {
    StoreStatus status;
    status.schema = schema_version();
    VACUFORM_CHECK(describe(db, status));
    status.disk = room_->space();
    VACUFORM_TRY(jobs, counts(db));
    status.counts = jobs;
    Query oldest(db, "SELECT created FROM job WHERE state='queued' ORDER BY id LIMIT 1");
    VACUFORM_TRY(waits, oldest.row());
    if (waits) status.oldest_queued = oldest.integer(0);
    VACUFORM_TRY(backup, last_time(db, "last_backup"));
    VACUFORM_TRY(check, last_time(db, "last_check"));
    status.last_backup = backup, status.last_check = check;
    {
      const std::lock_guard hold(damage_mutex_);
      status.damaged_jobs = static_cast<std::int64_t>(damaged_jobs_.size());
      status.damaged_files = static_cast<std::int64_t>(damaged_files_.size());
      status.unnamed_files = unnamed_files_, status.unnamed_bytes = unnamed_bytes_;
    }
    VACUFORM_TRY(leases, lease_times().current(db));
    std::map<std::string, Millis> heard;
    for (const auto& lease : leases) heard[lease.job] = lease.heard;
    Query running(
        db, "SELECT coalesce(worker, ''), id FROM job WHERE state IN ('running','cancelling') ORDER BY id");
    for (;;) {
      VACUFORM_TRY(more, running.row());
      if (!more) return status;
      const auto lease = heard.find(running.text(1));
      if (lease == heard.end()) continue;  // its worker is lost
      status.working.push_back({running.text(0), running.text(1), lease->second});
    }
  });
}

Result<void> SqlStore::remember(std::string_view event) {
  return write([&](Transaction& tx) {
    return Query(tx.db,
                 "INSERT INTO remembered(name, value) VALUES(?,?) ON CONFLICT(name) DO UPDATE SET "
                 "value=excluded.value",
                 event, options_.clock())
        .run();
  });
}

}  // namespace vacuform
