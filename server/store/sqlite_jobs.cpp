#include <algorithm>
#include <functional>
#include <limits>

#include "api/base/utf8.hpp"
#include "api/problem.hpp"
#include "server/store/job_id.hpp"
#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

// Keys are per owner: equal keys of two owners neither reveal a job nor cause a refusal.
std::string key_of(const NewJob& job) {
  return job.owner.empty() ? job.client_key : job.owner + "/" + job.client_key;
}

}  // namespace

Result<Job> SqliteStore::create(NewJob job, bool* repeated) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::vector<Blob> blobs;
  for (auto& input : job.inputs) {
    VACUFORM_TRY(blob, stored.add(input.file));
    blobs.push_back(blob);
  }
  auto created = write([&]() -> Result<Job> {
    if (!job.client_key.empty()) {
      VACUFORM_TRY(earlier, made_before(job, blobs));
      if (repeated) *repeated = earlier.has_value();
      if (earlier) return *earlier;
    }
    VACUFORM_CHECK(check_room(job.owner));
    VACUFORM_CHECK(room_for(0));
    const Millis now = options_.clock();
    last_id_time_ = std::max(now, last_id_time_ + 1);
    const std::string id = make_job_id(last_id_time_);
    std::optional<std::string> client_key;
    if (!job.client_key.empty()) client_key = key_of(job);
    VACUFORM_CHECK(Query(db_,
                         "INSERT INTO job(id, kind, client_key, state, created, settings, request, owner,"
                         " priority, derived_from, reference, note) VALUES(?,?,?,'queued',?,?,?,?,?,?,?,?)",
                         id, name(job.kind), client_key, now, job.settings, job.request, job.owner,
                         job.priority, job.derived_from, job.reference, job.note)
                       .run());
    for (std::size_t i = 0; i < blobs.size(); ++i) {
      VACUFORM_CHECK(check_shared(job.inputs[i]));
      VACUFORM_CHECK(Query(db_, "INSERT INTO input(job, name, blob, bytes, extension) VALUES(?,?,?,?,?)", id,
                           job.inputs[i].name, blobs[i].sha256, blobs[i].bytes, job.inputs[i].extension)
                         .run());
    }
    VACUFORM_CHECK(note(id, "queued"));
    return find(id);
  });
  stored.named = created.has_value();
  return created;
}

Result<void> SqliteStore::check_room(const std::string& owner) {
  Query query(
      db_, "SELECT coalesce(sum(queued), 0), coalesce(sum(queued) FILTER (WHERE owner=?), 0) FROM submitter",
      owner);
  VACUFORM_CHECK(query.row());
  if (query.integer(0) >= options_.most_queued)
    return fail(Code::busy, "the queue is full: " + std::to_string(query.integer(0)) + " jobs wait", {},
                "try again later");
  if (query.integer(1) >= options_.most_queued_by_owner)
    return fail(Code::busy, std::to_string(query.integer(1)) + " of your jobs wait already", {},
                "try again when some are done, or cancel some");
  return {};
}

Result<void> SqliteStore::check_shared(const NewInput& input) {
  const auto* blob = std::get_if<Blob>(&input.file);
  if (!blob) return {};
  VACUFORM_TRY(there, named(blob->sha256));
  if (there) return {};
  return fail(Code::gone, "the file was deleted in the meantime", input.name, "send it again");
}

// The job that an earlier submission with the same key created.
Result<std::optional<Job>> SqliteStore::made_before(const NewJob& job, const std::vector<Blob>& blobs) {
  Query query(db_, "SELECT id FROM job WHERE client_key=?", key_of(job));
  VACUFORM_TRY(found, query.row());
  if (!found) return std::optional<Job>();
  VACUFORM_TRY(earlier, find(query.text(0)));
  bool same = earlier.kind == job.kind && earlier.settings == job.settings &&
              earlier.priority == job.priority && earlier.derived_from == job.derived_from &&
              earlier.reference == job.reference && earlier.note == job.note &&
              earlier.inputs.size() == blobs.size();
  for (std::size_t i = 0; same && i < blobs.size(); ++i) {
    const Input* input = earlier.input(job.inputs[i].name);
    same = input && input->blob.sha256 == blobs[i].sha256;
  }
  if (!same)
    return fail(Code::conflict, "the idempotency key was used for another submission", earlier.id,
                "take a new key");
  return std::optional<Job>(std::move(earlier));
}

Result<Job> SqliteStore::find(const std::string& id, Detail detail) {
  Query query(
      db_,
      "SELECT id, state, stage, progress, attempt, created, started, ended, error_code, error_what,"
      " error_where, error_fix, request, owner, priority, derived_from, not_before, version, kind, settings,"
      " serious_warnings, reference, note"
      " FROM job WHERE id=?",
      id);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such job", id, "see the list of jobs");
  const auto state = job_state_from(query.text(1));
  const auto kind = job_kind_from(query.text(18));
  if (!state || !kind) return fail(Code::corrupt_file, "the job store is damaged: unknown state or kind", id);
  Job job;
  job.id = query.text(0);
  job.kind = *kind;
  job.state = *state;
  job.stage = stage_from(query.text(2));
  job.stage_progress = query.real(3);
  job.attempt = static_cast<int>(query.integer(4));
  job.created = query.integer(5);
  if (!query.null(6)) job.started = query.integer(6);
  if (!query.null(7)) job.ended = query.integer(7);
  if (!query.null(8))
    job.error = Error{code_from(query.text(8)).value_or(Code::internal), query.text(9), query.text(10),
                      query.text(11)};
  job.request = query.text(12);
  job.owner = query.text(13);
  job.priority = static_cast<int>(query.integer(14));
  if (!query.null(15)) job.derived_from = query.text(15);
  if (!query.null(16)) job.not_before = query.integer(16);
  job.version = query.integer(17);
  if (!query.null(20)) job.serious_warnings = static_cast<int>(query.integer(20));
  job.reference = query.text(21);
  job.note = query.text(22);
  if (detail == Detail::brief) return job;
  job.settings = query.text(19);
  Query inputs(db_, "SELECT name, blob, bytes, extension FROM input WHERE job=?", id);
  for (;;) {
    VACUFORM_TRY(more, inputs.row());
    if (!more) break;
    job.inputs.push_back(
        {inputs.text(0), {inputs.text(1), static_cast<std::uint64_t>(inputs.integer(2))}, inputs.text(3)});
  }
  std::sort(job.inputs.begin(), job.inputs.end(), [](const Input& a, const Input& b) {
    return input_kind(a.name) < input_kind(b.name);  // index in one table
  });
  if (!ended(job.state)) return job;  // incomplete
  VACUFORM_TRY(artifacts, artifacts_of(id));
  job.artifacts = std::move(artifacts);
  std::sort(job.artifacts.begin(), job.artifacts.end(), [](const StoredArtifact& a, const StoredArtifact& b) {
    return artifact_kind(a.name) < artifact_kind(b.name);  // index in one table
  });
  return job;
}

Result<std::vector<StoredArtifact>> SqliteStore::artifacts_of(const std::string& job) {
  std::vector<StoredArtifact> artifacts;
  Query query(db_, "SELECT name, blob, bytes FROM artifact WHERE job=?", job);
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return artifacts;
    artifacts.push_back({query.text(0), {query.text(1), static_cast<std::uint64_t>(query.integer(2))}});
  }
}

Result<Job> SqliteStore::job(const std::string& id) {
  const std::lock_guard hold(commits_.lock());
  return find(id);
}

// The newest `count` ids below `before`.
Result<std::vector<std::string>> SqliteStore::ids_of(int count, const std::string& before,
                                                     const JobFilter& filter) {
  std::vector<std::string> ids;
  const auto collect = [&](Query query) -> Result<void> {
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return {};
      ids.push_back(query.text(0));
    }
  };
  if (filter.states.empty() && !filter.kind && !filter.created_after && !filter.created_before) {
    VACUFORM_CHECK(
        filter.owner
            ? collect({db_, "SELECT id FROM job WHERE owner=? AND id<? ORDER BY id DESC LIMIT ?",
                       *filter.owner, before, count})
            : collect({db_, "SELECT id FROM job WHERE id<? ORDER BY id DESC LIMIT ?", before, count}));
    return ids;
  }
  // One state at a time, each from an index that covers the query. An id is never older than its job, so it bounds
  // created_after from below.
  std::optional<std::string_view> kind;
  if (filter.kind) kind = name(*filter.kind);
  const Millis after = filter.created_after.value_or(-1);
  const Millis until = filter.created_before.value_or(std::numeric_limits<Millis>::max());
  const std::string first = first_job_id(std::max<Millis>(after, 0));
  for (std::size_t i = 0; i < job_state_names.size(); ++i) {
    const auto state = static_cast<JobState>(i);
    if (!filter.states.empty() &&
        std::find(filter.states.begin(), filter.states.end(), state) == filter.states.end())
      continue;
    VACUFORM_CHECK(filter.owner
                       ? collect({db_,
                                  "SELECT id FROM job INDEXED BY job_by_owner_and_state WHERE owner=?1 AND "
                                  "state=?2 AND id<?3"
                                  " AND id>=?4 AND (?5 IS NULL OR kind=?5) AND created>?6 AND created<?7"
                                  " ORDER BY id DESC LIMIT ?8",
                                  *filter.owner, name(state), before, first, kind, after, until, count})
                       : collect({db_,
                                  "SELECT id FROM job INDEXED BY job_by_state WHERE state=?1 AND id<?2"
                                  " AND id>=?3 AND (?4 IS NULL OR kind=?4) AND created>?5 AND created<?6"
                                  " ORDER BY id DESC LIMIT ?7",
                                  name(state), before, first, kind, after, until, count}));
  }
  std::sort(ids.begin(), ids.end(), std::greater<>());
  if (ids.size() > static_cast<std::size_t>(count)) ids.resize(static_cast<std::size_t>(count));
  return ids;
}

Result<JobPage> SqliteStore::list(int limit, const std::string& cursor, const JobFilter& filter,
                                  Detail detail) {
  const std::lock_guard hold(commits_.lock());
  limit = std::clamp(limit, 1, 100);
  const int looked_at = filter.text.empty() ? limit : most_searched;
  VACUFORM_TRY(ids, ids_of(looked_at + 1, cursor.empty() ? "~" : cursor, filter));
  const bool more = ids.size() > static_cast<std::size_t>(looked_at);
  if (more) ids.pop_back();
  const std::u32string text = folded(filter.text);
  JobPage page;
  for (const auto& id : ids) {
    if (!filter.text.empty()) {
      VACUFORM_TRY(found, has_text(id, text));
      if (!found) continue;
    }
    if (page.jobs.size() == static_cast<std::size_t>(limit)) {  // one more than the page takes
      page.next = page.jobs.back().id;
      return page;
    }
    VACUFORM_TRY(job, find(id, detail));
    page.jobs.push_back(std::move(job));
  }
  if (more) page.next = ids.back();
  return page;
}

Result<bool> SqliteStore::has_text(const std::string& id, const std::u32string& folded_text) {
  if (folded(id).find(folded_text) != std::u32string::npos) return true;
  Query query(db_, "SELECT reference, note FROM job WHERE id=?", id);
  VACUFORM_TRY(found, query.row());
  return found && (folded(query.text(0)).find(folded_text) != std::u32string::npos ||
                   folded(query.text(1)).find(folded_text) != std::u32string::npos);
}

Result<std::optional<Job>> SqliteStore::newest_inspection(const StoredScan& scan) {
  const std::lock_guard hold(commits_.lock());
  Query query(db_,
              "SELECT job.id FROM input JOIN job ON job.id=input.job WHERE input.blob=? AND input.name='scan'"
              " AND input.extension=? AND job.kind='inspection' AND job.owner=? ORDER BY job.id DESC LIMIT 1",
              scan.blob.sha256, scan.extension, scan.owner);
  VACUFORM_TRY(found, query.row());
  if (!found) return std::optional<Job>();
  VACUFORM_TRY(job, find(query.text(0)));
  return std::optional(std::move(job));
}

Result<JobCounts> SqliteStore::counts() {
  const std::lock_guard hold(commits_.lock());
  return counts_now();
}

Result<JobCounts> SqliteStore::counts_now() {
  JobCounts counts{};
  Query query(db_, "SELECT state, count(*) FROM job GROUP BY state");
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    if (const auto state = job_state_from(query.text(0)))
      counts[static_cast<std::size_t>(*state)] = query.integer(1);
  }
  const Millis now = options_.elapsed();
  const auto count = [&](JobState state) -> std::int64_t& { return counts[static_cast<std::size_t>(state)]; };
  for (const auto& [id, ends] : leases_) {
    if (ends > now) continue;
    const auto job = find(id);
    if (!job) continue;
    if (job->state == JobState::running) --count(JobState::running), ++count(JobState::queued);
    if (job->state == JobState::cancelling) --count(JobState::cancelling), ++count(JobState::cancelled);
  }
  return counts;
}

Result<Job> SqliteStore::cancel(const std::string& id, const JobGuard& allowed) {
  const Deletion deletion(*this);
  return write([&]() -> Result<Job> {
    VACUFORM_TRY(job, find(id));
    if (allowed && !allowed(job)) return fail(Code::conflict, "the job has changed", id, "look at it again");
    VACUFORM_TRY(faults, faults_of(id));
    VACUFORM_TRY(next, when_cancel_asked(job, faults));
    VACUFORM_CHECK(apply(job, next));
    return find(id);
  });
}

Result<void> SqliteStore::remove(const std::string& id, const JobGuard& allowed) {
  const Deletion deletion(*this);
  return write([&]() -> Result<void> {
    VACUFORM_TRY(job, find(id));
    if (allowed && !allowed(job)) return fail(Code::conflict, "the job has changed", id, "look at it again");
    VACUFORM_CHECK(may_be_deleted(job));
    for (const auto& input : job.inputs) maybe_garbage(input.blob.sha256);
    VACUFORM_CHECK(drop_artifacts(job));
    changed_.push_back(id);  // waiting clients learn that it is gone
    return Query(db_, "DELETE FROM job WHERE id=?", id).run();
  });
}

Result<void> SqliteStore::note(const std::string& job, std::string_view text) {
  VACUFORM_CHECK(Query(db_,
                       "INSERT INTO job_log(job, number, time, text) VALUES(?1,"
                       " (SELECT coalesce(max(number), 0) + 1 FROM job_log WHERE job=?1), ?2, ?3)",
                       job, options_.clock(), text)
                     .run());
  return tell(job);
}

Result<void> SqliteStore::tell(const std::string& job) {
  changed_.push_back(job);
  return Query(db_, "UPDATE job SET version=version+1 WHERE id=?", job).run();
}

Result<std::vector<LogLine>> SqliteStore::log_after(const std::string& id, std::int64_t number, int limit) {
  const std::lock_guard hold(commits_.lock());
  VACUFORM_CHECK(find(id));
  Query query(db_, "SELECT number, time, text FROM job_log WHERE job=? AND number>? ORDER BY number LIMIT ?",
              id, number, std::clamp(limit, 1, 1000));
  std::vector<LogLine> lines;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return lines;
    lines.push_back({query.integer(0), query.integer(1), query.text(2)});
  }
}

Result<Job> SqliteStore::wait_for_change(const std::string& id, std::int64_t version,
                                         std::chrono::milliseconds time) {
  Result<Job> seen = fail(Code::busy, "too many clients wait for changes of jobs", id, "ask again later");
  news_.wait(id, time, [&] {
    seen = job(id);
    return !seen || seen->version > version;
  });
  return seen;
}

}  // namespace vacuform
