#include <algorithm>
#include <limits>

#include "api/base/secrets.hpp"
#include "api/problem.hpp"
#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

std::string failed_with(const std::optional<Error>& error) {
  return "failed: " + std::string(meaning(error->code).slug);
}

Millis rest_after(int faults, Millis first) {
  constexpr Millis longest = 10 * 60 * 1000;
  const Millis rest = std::min(longest, first << std::min(faults - 1, 20));
  const auto chance = static_cast<Millis>(std::stoul(random_hex(3), nullptr, 16));  // of 2^24
  return rest / 2 + ((rest * chance) >> 24);
}

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
    const Millis now = options_.clock();
    VACUFORM_CHECK(
        Query(db_,
              "UPDATE job SET state='running', attempt=attempt+1, started=?, stage=NULL, progress=0,"
              " worker=?, lease_hash=?, log_lines=0, not_before=NULL WHERE id=?",
              now, worker, text_hash(token), id)
            .run());
    leases_[id] = options_.elapsed() + options_.lease;
    VACUFORM_TRY(job, find(id));
    VACUFORM_CHECK(Query(db_,
                         "UPDATE submitter SET served=(SELECT max(served) + 1 FROM submitter) WHERE owner=?",
                         job.owner)
                       .run());
    VACUFORM_CHECK(note(id, "attempt " + std::to_string(job.attempt) + " begins"));
    return std::optional<LeasedJob>(LeasedJob{std::move(job), token});
  });
}

Result<std::optional<std::string>> SqliteStore::next_queued() {
  const Millis now = steady_now();
  Query raised(db_,
               // By itself SQLite goes through the whole queue by another index.
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
    if (found) return std::optional(own.text(0));  // else all of them rest
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
    leases_[job.id] = options_.elapsed() + options_.lease;  // without a write, unless there is something new
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
      if (number++ != heard) continue;  // known already, or others before it are missing
      if (heard >= most_log_lines) break;
      VACUFORM_CHECK(note(job.id, cleaned(line)));
      ++heard;
    }
    return Query(db_, "UPDATE job SET log_lines=? WHERE id=?", heard, job.id).run();
  });
}

Result<void> SqliteStore::put_artifact(const LeaseKey& key, const std::string& name, Upload upload) {
  const Deletion deletion(*this);
  VACUFORM_TRY(blob, blobs_.seal(upload));
  return write([&]() -> Result<void> {
    VACUFORM_TRY(job, holder(key, false));
    maybe_garbage(blob.sha256);
    VACUFORM_TRY(artifacts, artifacts_of(job.id));
    for (const auto& old : artifacts)
      if (old.name == name) maybe_garbage(old.blob.sha256);
    VACUFORM_CHECK(blobs_.keep(upload));
    return Query(db_, "INSERT OR REPLACE INTO artifact(job, name, blob, bytes) VALUES(?,?,?,?)", job.id, name,
                 blob.sha256, blob.bytes)
        .run();
  });
}

Result<Job> SqliteStore::release(const LeaseKey& key) {
  const Deletion deletion(*this);
  return write([&]() -> Result<Job> {
    VACUFORM_TRY(job, holder(key, false));
    if (job.state == JobState::cancelling) {
      VACUFORM_CHECK(end(job, JobState::cancelled, {}));
    } else {
      VACUFORM_CHECK(queue_again(job, {}, "given back by its worker"));
    }
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

Result<SqliteStore::Faults> SqliteStore::faults_of(const std::string& job) {
  Query query(db_, "SELECT losses, crashes FROM job WHERE id=?", job);
  VACUFORM_CHECK(query.row());
  return Faults{static_cast<int>(query.integer(0)), static_cast<int>(query.integer(1))};
}

Result<Job> SqliteStore::finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error,
                                Retry retry, std::optional<int> serious_warnings) {
  const Deletion deletion(*this);
  return write([&]() -> Result<Job> {
    VACUFORM_TRY(job, holder(key, true));
    if (ended(job.state)) return job;
    if (job.state == JobState::cancelling) wanted = JobState::cancelled;
    if (wanted == JobState::succeeded) VACUFORM_CHECK(check_artifacts(job));
    if (wanted == JobState::failed && retry != Retry::never) {
      VACUFORM_TRY(faults, faults_of(job.id));
      ++(retry == Retry::after_crash ? faults.crashes : faults.losses);
      if (faults.losses < options_.losses && faults.crashes < options_.crashes) {
        VACUFORM_CHECK(queue_again(
            job, faults,
            retry == Retry::after_crash ? "its process broke down" : "its worker met a fault of its own"));
        return find(job.id);
      }
    }
    VACUFORM_CHECK(end(job, wanted, wanted == JobState::failed ? error : std::nullopt));
    if (wanted == JobState::succeeded && serious_warnings)
      VACUFORM_CHECK(
          Query(db_, "UPDATE job SET serious_warnings=? WHERE id=?", *serious_warnings, job.id).run());
    return find(job.id);
  });
}

// The hash of the lease stays, so that the same ending under the same token can be answered again.
// Only a job that has succeeded keeps artifacts: half a set helps nobody.
Result<void> SqliteStore::end(const Job& job, JobState state, const std::optional<Error>& error) {
  if (state != JobState::succeeded) {
    VACUFORM_CHECK(drop_artifacts(job));
  }
  const Millis now = options_.clock();
  std::optional<std::string_view> code, what, where, mend;
  if (error) code = meaning(error->code).slug, what = error->what, where = error->where, mend = error->mend;
  VACUFORM_CHECK(Query(db_,
                       "UPDATE job SET state=?, ended=?, error_code=?, error_what=?, error_where=?,"
                       " error_mend=? WHERE id=?",
                       name(state), now, code, what, where, mend, job.id)
                     .run());
  ended_jobs_.push_back(job);
  ended_jobs_.back().state = state;
  ended_jobs_.back().ended = now;
  return note(job.id, error ? failed_with(error) : std::string(name(state)));
}

Result<void> SqliteStore::check_artifacts(const Job& job) {
  VACUFORM_TRY(artifacts, artifacts_of(job.id));
  std::string missing;
  for (const ArtifactKind& kind : artifact_kinds)
    if (due(job.kind, kind) && std::none_of(artifacts.begin(), artifacts.end(),
                                            [&](const StoredArtifact& a) { return a.name == kind.name; }))
      missing.append(missing.empty() ? "" : ", ").append(kind.name);
  if (missing.empty()) return {};
  return fail(Code::conflict, "the job lacks artifacts that it must have: " + missing, job.id,
              "send them before the job is completed, or say that it failed");
}

Result<void> SqliteStore::drop_artifacts(const Job& job) {
  VACUFORM_TRY(artifacts, artifacts_of(job.id));
  for (const auto& artifact : artifacts) maybe_garbage(artifact.blob.sha256);
  return Query(db_, "DELETE FROM artifact WHERE job=?", job.id).run();
}

// Back to the queue, to rest after a fault; what the attempt left behind is dropped.
Result<void> SqliteStore::queue_again(const Job& job, const Faults& faults, const std::string& why) {
  VACUFORM_CHECK(drop_artifacts(job));
  const int count = faults.losses + faults.crashes;
  std::optional<Millis> not_before;
  if (count > 0) not_before = steady_now() + rest_after(count, options_.backoff);
  VACUFORM_CHECK(Query(db_,
                       "UPDATE job SET state='queued', stage=NULL, progress=0, started=NULL, worker=NULL,"
                       " lease_hash=NULL, losses=max(losses, ?), crashes=max(crashes, ?),"
                       " not_before=? WHERE id=?",
                       faults.losses, faults.crashes, not_before, job.id)
                     .run());
  return note(job.id, why + ", queued again");
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
    if (!found || (found->state != JobState::running && found->state != JobState::cancelling)) {
      leases_.erase(id);  // only now: a change that ended the lease may have been undone
      continue;
    }
    const Job& job = *found;
    VACUFORM_TRY(faults, faults_of(id));
    ++faults.losses;
    JobState state = JobState::queued;
    if (job.state == JobState::cancelling) {
      state = JobState::cancelled;
      VACUFORM_CHECK(end(job, state, {}));
    } else if (faults.losses >= options_.losses) {
      state = JobState::failed;
      VACUFORM_CHECK(end(
          job, state,
          Error{Code::internal, std::to_string(faults.losses) + " workers were lost while they ran this job",
                id, "look at the workers' logs; a coarser sheet.resolution_mm needs less memory"}));
    } else {
      VACUFORM_CHECK(queue_again(job, faults, "its worker was lost"));
    }
    // The lost worker must not hear that its lease was good.
    VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_hash=NULL WHERE id=?", id).run());
    expired.push_back({id, state});
  }
  return expired;
}

}  // namespace vacuform
