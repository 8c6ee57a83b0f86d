#include <algorithm>
#include <limits>

#include "api/base/secrets.hpp"
#include "api/problem.hpp"
#include "server/store/sqlite_store.hpp"

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

Result<std::optional<LeasedJob>> SqliteStore::lease(const std::string& worker) {
  return write([&]() -> Result<std::optional<LeasedJob>> {
    VACUFORM_TRY(expired, expire_now());
    if (!room_->check(Use::begin_job)) return std::optional<LeasedJob>();
    VACUFORM_TRY(next, next_queued());
    if (!next) return std::optional<LeasedJob>();
    const std::string id = *next, token = random_hex(32);
    VACUFORM_TRY(queued, find(id, Detail::brief));
    VACUFORM_TRY(faults, faults_of(id));
    VACUFORM_TRY(begun, when_leased(queued, faults));
    VACUFORM_CHECK(Query(db_,
                         "UPDATE job SET started=?, stage=NULL, progress=0, worker=?, lease_hash=?,"
                         " log_lines=0, not_before=NULL WHERE id=?",
                         options_.clock(), worker, text_hash(token), id)
                       .run());
    VACUFORM_CHECK(apply(queued, begun));
    leases_[id] = options_.elapsed() + options_.lease;
    VACUFORM_TRY(job, find(id));
    VACUFORM_CHECK(Query(db_,
                         "UPDATE submitter SET served=(SELECT max(served) + 1 FROM submitter) WHERE owner=?",
                         job.owner)
                       .run());
    return std::optional<LeasedJob>(LeasedJob{std::move(job), token});
  });
}

Result<std::optional<std::string>> SqliteStore::next_queued() {
  const Millis now = steady_now();
  Query raised(db_,
               // Without INDEXED BY, SQLite scans the whole queue with another index.
               "SELECT id FROM job INDEXED BY job_raised WHERE state='queued' AND priority>0"
               " AND (not_before IS NULL OR not_before<=?) ORDER BY priority DESC, id LIMIT 1",
               now);
  VACUFORM_TRY(found_raised, raised.row());
  if (found_raised) return std::optional(raised.text(0));
  Query turns(db_, "SELECT owner FROM submitter WHERE queued>0 ORDER BY running, served, owner");
  for (;;) {
    VACUFORM_TRY(more, turns.row());
    if (!more) return std::optional<std::string>();
    Query own(db_,
              "SELECT id FROM job WHERE state='queued' AND owner=? AND (not_before IS NULL OR not_before<=?)"
              " ORDER BY priority DESC, id LIMIT 1",
              turns.text(0), now);
    VACUFORM_TRY(found, own.row());
    if (found) return std::optional(own.text(0));  // otherwise all its jobs are resting
  }
}

Result<Job> SqliteStore::leased(const LeaseKey& key) {
  return write([&] { return holder(key, false); });
}

Result<bool> SqliteStore::heartbeat(const LeaseKey& key, std::optional<Stage> stage, double progress) {
  return write([&]() -> Result<bool> {
    VACUFORM_TRY(job, holder(key, false));
    std::optional<std::string_view> stage_name;
    if (stage) stage_name = name(*stage);
    leases_[job.id] = options_.elapsed() + options_.lease;  // without a write, unless something has changed
    progress = std::clamp(progress, 0.0, 1.0);
    if (stage != job.stage || progress != job.stage_progress) {
      VACUFORM_CHECK(
          Query(db_, "UPDATE job SET stage=?, progress=? WHERE id=?", stage_name, progress, job.id).run());
      VACUFORM_CHECK(tell(job.id));
    }
    return job.state == JobState::cancelling;
  });
}

Result<void> SqliteStore::log(const LeaseKey& key, int first, const std::vector<std::string>& lines) {
  return write([&]() -> Result<void> {
    VACUFORM_TRY(job, holder(key, false));
    Query query(db_, "SELECT log_lines FROM job WHERE id=?", job.id);
    VACUFORM_CHECK(query.row());
    std::int64_t number = first, heard = query.integer(0);
    for (const std::string& line : lines) {
      if (number++ != heard) continue;  // already known, or lines before it are missing
      if (heard >= most_log_lines) break;
      VACUFORM_CHECK(note(job.id, cleaned(line)));
      ++heard;
    }
    return Query(db_, "UPDATE job SET log_lines=? WHERE id=?", heard, job.id).run();
  });
}

Result<void> SqliteStore::put_artifact(const LeaseKey& key, const std::string& name, Upload upload) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::variant<Upload, Blob> file(std::move(upload));
  VACUFORM_TRY(blob, stored.add(file));
  auto put = write([&]() -> Result<void> {
    VACUFORM_TRY(job, holder(key, false));
    VACUFORM_TRY(artifacts, artifacts_of(job.id));
    for (const auto& old : artifacts)
      if (old.name == name) maybe_garbage(old.blob.sha256);
    return Query(db_, "INSERT OR REPLACE INTO artifact(job, name, blob, bytes) VALUES(?,?,?,?)", job.id, name,
                 blob.sha256, blob.bytes)
        .run();
  });
  stored.named = put.has_value();
  return put;
}

Result<Job> SqliteStore::release(const LeaseKey& key) {
  const Deletion deletion(*this);
  return write([&]() -> Result<Job> {
    VACUFORM_TRY(job, holder(key, false));
    VACUFORM_TRY(faults, faults_of(job.id));
    VACUFORM_TRY(next, when_given_back(job, faults));
    VACUFORM_CHECK(apply(job, next));
    return find(job.id);
  });
}

Result<std::vector<Expired>> SqliteStore::bury(const std::string& worker) {
  const Deletion deletion(*this);
  return write([&]() -> Result<std::vector<Expired>> {
    Query held(db_, "SELECT id FROM job WHERE state IN ('running','cancelling') AND worker=?", worker);
    for (;;) {
      VACUFORM_TRY(more, held.row());
      if (!more) break;
      leases_[held.text(0)] = std::numeric_limits<Millis>::min();
    }
    return expire_now();
  });
}

// The job that the key's lease holds. Ended jobs count only when `even_ended`.
Result<Job> SqliteStore::holder(const LeaseKey& key, bool even_ended) {
  VACUFORM_TRY(expired, expire_now());
  Query query(db_, "SELECT lease_hash FROM job WHERE id=? AND lease_hash IS NOT NULL", key.job);
  VACUFORM_TRY(found, query.row());
  if (found && equal_secrets(query.text(0), text_hash(key.token))) {
    VACUFORM_TRY(job, find(key.job));
    if (even_ended || !ended(job.state)) return job;
  }
  return fail(Code::lease_lost, "the lease of this job has ended", key.job,
              "stop working on this job and ask for another");
}

Result<Faults> SqliteStore::faults_of(const std::string& job) {
  Query query(db_, "SELECT losses, crashes FROM job WHERE id=?", job);
  VACUFORM_CHECK(query.row());
  return Faults{static_cast<int>(query.integer(0)), static_cast<int>(query.integer(1))};
}

Result<Job> SqliteStore::finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error,
                                Retry retry, std::optional<int> serious_warnings) {
  const Deletion deletion(*this);
  return write([&]() -> Result<Job> {
    VACUFORM_TRY(job, holder(key, true));
    VACUFORM_TRY(faults, faults_of(job.id));
    VACUFORM_TRY(artifacts, artifacts_of(job.id));
    VACUFORM_TRY(next, when_finished(job, faults, {wanted, error, retry, artifacts}, limits(), chance()));
    VACUFORM_CHECK(apply(job, next));
    if (next.changes && next.state == JobState::succeeded && serious_warnings)
      VACUFORM_CHECK(
          Query(db_, "UPDATE job SET serious_warnings=? WHERE id=?", *serious_warnings, job.id).run());
    return find(job.id);
  });
}

// The hash of the lease stays with a job that a worker has ended, so that a repeated request with the same token gets
// the same answer. Only a job that has succeeded keeps all artifacts: an incomplete set is useless, except for what
// explains a failure.
Result<void> SqliteStore::apply(const Job& job, const Transition& next) {
  if (!next.changes) return {};
  VACUFORM_CHECK(Query(db_, "UPDATE job SET state=?, attempt=?, losses=?, crashes=? WHERE id=?",
                       name(next.state), next.attempt, next.faults.losses, next.faults.crashes, job.id)
                     .run());
  if (next.state == JobState::queued || (ended(next.state) && next.state != JobState::succeeded))
    VACUFORM_CHECK(drop_artifacts(job, next.explained));
  if (next.state == JobState::queued) {
    std::optional<Millis> not_before;
    if (next.rest) not_before = steady_now() + *next.rest;
    VACUFORM_CHECK(
        Query(db_,
              "UPDATE job SET stage=NULL, progress=0, started=NULL, worker=NULL, not_before=? WHERE id=?",
              not_before, job.id)
            .run());
  }
  if (ended(next.state)) VACUFORM_CHECK(write_end(job, next));
  if (next.forgets_lease)
    VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_hash=NULL WHERE id=?", job.id).run());
  return note(job.id, next.line);
}

Result<void> SqliteStore::write_end(const Job& job, const Transition& next) {
  const Millis now = options_.clock();
  std::optional<std::string_view> code, what, where, fix;
  if (const auto& error = next.error)
    code = meaning(error->code).slug, what = error->what, where = error->where, fix = error->fix;
  ended_jobs_.push_back(job);
  ended_jobs_.back().state = next.state;
  ended_jobs_.back().ended = now;
  return Query(db_,
               "UPDATE job SET ended=?, error_code=?, error_what=?, error_where=?, error_fix=? WHERE id=?",
               now, code, what, where, fix, job.id)
      .run();
}

Result<void> SqliteStore::drop_artifacts(const Job& job, bool but_explaining) {
  VACUFORM_TRY(artifacts, artifacts_of(job.id));
  for (const auto& artifact : artifacts) {
    const ArtifactKind* kind = artifact_kind(artifact.name);
    if (but_explaining && kind && explains_failure(job.kind, *kind)) continue;
    maybe_garbage(artifact.blob.sha256);
    VACUFORM_CHECK(Query(db_, "DELETE FROM artifact WHERE job=? AND name=?", job.id, artifact.name).run());
  }
  return {};
}

Result<std::vector<Expired>> SqliteStore::expire_now() {
  const Millis now = options_.elapsed();
  std::vector<std::string> over;
  for (const auto& [id, ends] : leases_)
    if (ends <= now) over.push_back(id);
  std::vector<Expired> expired;
  for (const auto& id : over) {
    const auto found = find(id);
    if (!found && found.error().code != Code::not_found) return tl::make_unexpected(found.error());
    Result<Transition> next = fail(Code::lease_lost, "");
    if (found) {
      VACUFORM_TRY(faults, faults_of(id));
      next = when_expired(*found, faults, limits(), chance());
    }
    if (!next) {
      leases_.erase(id);  // only now: the change that ended the lease may have been rolled back
      continue;
    }
    VACUFORM_CHECK(apply(*found, *next));
    expired.push_back({id, next->state});
  }
  return expired;
}

}  // namespace vacuform
