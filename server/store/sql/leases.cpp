#include <algorithm>

#include "api/base/secrets.hpp"
#include "api/problem.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

std::uint32_t chance() { return static_cast<std::uint32_t>(std::stoul(random_hex(3), nullptr, 16)); }

std::string cleaned(const std::string& line) {
  std::string text = line.substr(0, longest_log_line);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

}  // namespace

Result<std::optional<LeasedJob>> SqlStore::lease(const std::string& worker) {
  return write_for_worker([&](Transaction& tx) -> Result<std::optional<LeasedJob>> {
    if (!room_->check(Use::begin_job)) return std::optional<LeasedJob>();
    VACUFORM_TRY(next, next_queued(tx.db));
    if (!next) return std::optional<LeasedJob>();
    const std::string token = random_hex(32);
    VACUFORM_TRY(row, find_row(tx.db, *next, Lock::yes, Detail::full));
    VACUFORM_TRY(change, when_leased(row.job, row.faults));
    row.job.started = options_.clock();
    row.job.stage.reset(), row.job.not_before.reset();
    row.job.stage_progress = 0;
    row.worker = worker;
    row.lease_hash = text_hash(token);
    row.log_lines = 0;
    VACUFORM_CHECK(apply(tx, row, change));
    VACUFORM_CHECK(lease_times().renew(tx.db, row.job.id));
    VACUFORM_CHECK(Query(tx.db,
                         "UPDATE submitter SET served=(SELECT max(served) + 1 FROM submitter) WHERE owner=?",
                         row.job.owner)
                       .run());
    return std::optional<LeasedJob>(LeasedJob{std::move(row.job), token});
  });
}

Result<Job> SqlStore::leased(const LeaseKey& key) {
  return write_for_worker([&](Transaction& tx) -> Result<Job> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::full));
    return std::move(row.job);
  });
}

Result<bool> SqlStore::heartbeat(const LeaseKey& key, std::optional<Stage> stage, double progress) {
  return write_for_worker([&](Transaction& tx) -> Result<bool> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::brief));
    VACUFORM_CHECK(lease_times().renew(tx.db, row.job.id));
    const double clamped = std::clamp(progress, 0.0, 1.0);
    if (stage != row.job.stage || clamped != row.job.stage_progress) {
      row.job.stage = stage;
      row.job.stage_progress = clamped;
      VACUFORM_CHECK(save(tx, row));
    }
    return row.job.state == JobState::cancelling;
  });
}

Result<void> SqlStore::log(const LeaseKey& key, int first, const std::vector<std::string>& lines) {
  return write_for_worker([&](Transaction& tx) -> Result<void> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::brief));
    const std::int64_t before = row.log_lines;
    std::int64_t number = first;
    for (const std::string& line : lines) {
      if (number++ != row.log_lines) continue;  // already known, or lines before it are missing
      if (row.log_lines >= most_log_lines) break;
      VACUFORM_CHECK(add_line(tx.db, row.job.id, cleaned(line)));
      ++row.log_lines;
    }
    if (row.log_lines == before) return {};
    return save(tx, row);
  });
}

Result<void> SqlStore::put_artifact(const LeaseKey& key, const std::string& name, Upload upload) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::variant<Upload, Blob> file(std::move(upload));
  VACUFORM_TRY(blob, stored.add(file));
  auto put = write_for_worker([&](Transaction& tx) -> Result<void> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::full));
    for (const auto& old : row.stored)
      if (old.name == name) tx.garbage.push_back(old.blob.sha256);
    VACUFORM_CHECK(hold_objects(tx.db, {blob.sha256}));
    return Query(tx.db,
                 "INSERT INTO artifact(job, name, blob, bytes) VALUES(?,?,?,?)"
                 " ON CONFLICT(job, name) DO UPDATE SET blob=excluded.blob, bytes=excluded.bytes",
                 row.job.id, name, blob.sha256, blob.bytes)
        .run();
  });
  stored.written(put);
  return put;
}

Result<Job> SqlStore::release(const LeaseKey& key) {
  const Deletion deletion(*this);
  return write_for_worker([&](Transaction& tx) -> Result<Job> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::full));
    VACUFORM_TRY(next, when_given_back(row.job, row.faults));
    VACUFORM_CHECK(apply(tx, row, next));
    return std::move(row.job);
  });
}

Result<Job> SqlStore::finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error,
                             Retry retry, std::optional<int> serious_warnings) {
  const Deletion deletion(*this);
  return write_for_worker([&](Transaction& tx) -> Result<Job> {
    VACUFORM_TRY(row, holder(tx.db, key, Detail::full, true));
    VACUFORM_TRY(next,
                 when_finished(row.job, row.faults, {wanted, error, retry, row.stored}, limits(), chance()));
    if (next.changes && next.state == JobState::succeeded) {
      row.job.serious_warnings = serious_warnings;
      row.job.artifacts = row.stored;
    }
    VACUFORM_CHECK(apply(tx, row, next));
    return std::move(row.job);
  });
}

Result<SqlStore::JobRow> SqlStore::holder(Database& db, const LeaseKey& key, Detail detail, bool even_ended) {
  auto row = find_row(db, key.job, Lock::yes, detail);
  if (!row && row.error().code != Code::not_found) return row;
  if (row && !row->lease_hash.empty() && equal_secrets(row->lease_hash, text_hash(key.token)) &&
      (even_ended || !ended(row->job.state)))
    return row;
  return fail(Code::lease_lost, "the lease of this job has ended", key.job,
              "stop working on this job and ask for another");
}

Result<std::vector<Expired>> SqlStore::expire() {
  const Deletion deletion(*this);
  auto expired = end_leases();
  blobs_->collect_again([this](const std::string& blob) { return wanted(blob); });
  room_->restore();
  return expired;
}

Result<std::vector<Expired>> SqlStore::end_leases_of(const std::string& worker) {
  const auto ended = write([&](Transaction& tx) -> Result<void> {
    Query held(tx.db, "SELECT id FROM job WHERE state IN ('running','cancelling') AND worker=?", worker);
    for (;;) {
      VACUFORM_TRY(more, held.row());
      if (!more) return {};
      VACUFORM_CHECK(lease_times().end(tx.db, held.text(0)));
    }
  });
  if (!ended) return tl::make_unexpected(ended.error());
  return expire();
}

// In a transaction of its own, so that no other waits for the jobs of lost workers.
Result<std::vector<Expired>> SqlStore::end_leases() {
  if (lease_times().surely_none_over()) return std::vector<Expired>();
  VACUFORM_TRY(some, read([&](Database& db) { return lease_times().over(db, false); }));
  if (some.empty()) return std::vector<Expired>();
  const Deletion deletion(*this);
  return write([&](Transaction& tx) -> Result<std::vector<Expired>> {
    std::vector<Expired> expired;
    VACUFORM_TRY(over, lease_times().over(tx.db, true));
    for (const std::string& id : over) {
      auto row = find_row(tx.db, id, Lock::yes, Detail::full);
      if (!row && row.error().code != Code::not_found) return tl::make_unexpected(row.error());
      const Result<Transition> next =
          row ? when_expired(row->job, row->faults, limits(), chance()) : fail(Code::lease_lost, "");
      if (!next) {
        VACUFORM_CHECK(lease_times().forget(tx.db, id));
        continue;
      }
      VACUFORM_CHECK(apply(tx, *row, *next));
      expired.push_back({id, next->state});
    }
    return expired;
  });
}

}  // namespace vacuform
