#include <algorithm>
#include <functional>
#include <limits>

#include "api/base/utf8.hpp"
#include "api/problem.hpp"
#include "server/store/job_id.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

// Keys are per owner: equal keys of two owners neither reveal a job nor cause a refusal.
std::string key_of(const NewJob& job) {
  return job.owner.empty() ? job.client_key : job.owner + "/" + job.client_key;
}

// As find() reads it.
Job queued_job(const NewJob& made, const std::vector<Blob>& blobs, const std::string& id, Millis now) {
  Job job;
  job.id = id;
  job.kind = made.kind;
  job.created = now;
  job.settings = made.settings;
  job.request = made.request;
  job.owner = made.owner;
  job.priority = made.priority;
  job.derived_from = made.derived_from;
  job.reference = made.reference;
  job.note = made.note;
  job.version = 1;
  for (std::size_t i = 0; i < blobs.size(); ++i)
    job.inputs.push_back({made.inputs[i].name, blobs[i], made.inputs[i].extension});
  sort_inputs(job.inputs);
  return job;
}

}  // namespace

Result<Job> SqlStore::create(NewJob job, bool* repeated) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::vector<Blob> blobs;
  for (auto& input : job.inputs) {
    VACUFORM_TRY(blob, stored.add(input.file));
    blobs.push_back(blob);
  }
  const std::optional<std::string> client_key =
      job.client_key.empty() ? std::nullopt : std::optional(key_of(job));
  auto created = write([&](Transaction& tx) -> Result<Job> {
    Query same_key(tx.db, "SELECT id FROM job WHERE client_key=?", client_key);
    Query waiting(
        tx.db,
        "SELECT coalesce(sum(queued), 0), coalesce(sum(queued) FILTER (WHERE owner=?), 0) FROM submitter",
        job.owner);
    if (client_key) same_key.send();
    waiting.send();
    SharedBlobs shared(tx.db, job.inputs);
    if (client_key) {
      VACUFORM_TRY(earlier, made_before(tx.db, same_key, job, blobs));
      if (repeated) *repeated = earlier.has_value();
      if (earlier) return *earlier;
    }
    VACUFORM_CHECK(check_room(waiting));
    VACUFORM_CHECK(shared.check());
    VACUFORM_CHECK(room_for(0));
    VACUFORM_CHECK(claim_reference_of(tx.db, job, blobs));
    const Millis now = options_.clock();
    const std::string id = next_id();
    VACUFORM_CHECK(Query(tx.db,
                         "INSERT INTO job(id, kind, client_key, state, created, settings, request, owner,"
                         " priority, derived_from, reference, note) VALUES(?,?,?,'queued',?,?,?,?,?,?,?,?)",
                         id, name(job.kind), client_key, now, job.settings, job.request, job.owner,
                         job.priority, job.derived_from, job.reference, job.note)
                       .run());
    std::vector<std::string> hashes;
    for (const Blob& blob : blobs) hashes.push_back(blob.sha256);
    VACUFORM_CHECK(hold_objects(tx.db, std::move(hashes)));
    for (std::size_t i = 0; i < blobs.size(); ++i) {
      VACUFORM_CHECK(Query(tx.db, "INSERT INTO input(job, name, blob, bytes, extension) VALUES(?,?,?,?,?)",
                           id, job.inputs[i].name, blobs[i].sha256, blobs[i].bytes, job.inputs[i].extension)
                         .run());
    }
    VACUFORM_CHECK(add_line(tx.db, id, "queued"));
    if (job.rescan) VACUFORM_CHECK(add_line(tx.db, id, "confirmed as another scan of the same patient"));
    tx.changed.push_back(id);
    return queued_job(job, blobs, id, now);
  });
  stored.written(created);
  return created;
}

Result<void> SqlStore::check_room(Query& waiting) const {
  VACUFORM_CHECK(waiting.row());
  if (waiting.integer(0) >= options_.most_queued)
    return fail(Code::busy, "the queue is full: " + std::to_string(waiting.integer(0)) + " jobs wait", {},
                "try again later");
  if (waiting.integer(1) >= options_.most_queued_by_owner)
    return fail(Code::busy, std::to_string(waiting.integer(1)) + " of your jobs wait already", {},
                "try again when some are done, or cancel some");
  return {};
}

// The job that an earlier submission with the same key created.
Result<std::optional<Job>> SqlStore::made_before(Database& db, Query& same_key, const NewJob& job,
                                                 const std::vector<Blob>& blobs) {
  VACUFORM_TRY(found, same_key.row());
  if (!found) return std::optional<Job>();
  VACUFORM_TRY(earlier, find(db, same_key.text(0)));
  bool same = earlier.kind == job.kind && earlier.settings == job.settings &&
              earlier.priority == job.priority && earlier.derived_from == job.derived_from &&
              first_reference(earlier) == job.reference && earlier.note == job.note &&
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

Result<Job> SqlStore::job(const std::string& id) {
  return read([&](Database& db) { return find(db, id); });
}

// The newest `count` ids below `before`.
Result<std::vector<std::string>> SqlStore::ids_of(Database& db, int count, const std::string& before,
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
            ? collect({db, "SELECT id FROM job WHERE owner=? AND id<? ORDER BY id DESC LIMIT ?",
                       *filter.owner, before, count})
            : collect({db, "SELECT id FROM job WHERE id<? ORDER BY id DESC LIMIT ?", before, count}));
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
                       ? collect({db,
                                  "SELECT id FROM job INDEXED BY job_by_owner_and_state WHERE owner=?1 AND "
                                  "state=?2 AND id<?3"
                                  " AND id>=?4 AND kind=coalesce(?5, kind) AND created>?6 AND created<?7"
                                  " ORDER BY id DESC LIMIT ?8",
                                  *filter.owner, name(state), before, first, kind, after, until, count})
                       : collect({db,
                                  "SELECT id FROM job INDEXED BY job_by_state WHERE state=?1 AND id<?2"
                                  " AND id>=?3 AND kind=coalesce(?4, kind) AND created>?5 AND created<?6"
                                  " ORDER BY id DESC LIMIT ?7",
                                  name(state), before, first, kind, after, until, count}));
  }
  std::sort(ids.begin(), ids.end(), std::greater<>());
  if (ids.size() > static_cast<std::size_t>(count)) ids.resize(static_cast<std::size_t>(count));
  return ids;
}

Result<JobPage> SqlStore::list(int limit, const std::string& cursor, const JobFilter& filter, Detail detail) {
  return read([&](Database& db) -> Result<JobPage> {
    limit = std::clamp(limit, 1, 100);
    const int looked_at = filter.text.empty() ? limit : most_searched;
    VACUFORM_TRY(ids, ids_of(db, looked_at + 1, cursor.empty() ? "~" : cursor, filter));
    const bool more = ids.size() > static_cast<std::size_t>(looked_at);
    if (more) ids.pop_back();
    const std::u32string text = folded(filter.text);
    JobPage page;
    for (const auto& id : ids) {
      if (!filter.text.empty()) {
        VACUFORM_TRY(found, has_text(db, id, text));
        if (!found) continue;
      }
      if (page.jobs.size() == static_cast<std::size_t>(limit)) {  // one more than the page takes
        page.next = page.jobs.back().id;
        return page;
      }
      auto job = find(db, id, detail);
      if (!job && job.error().code == Code::not_found) continue;  // deleted since its id was read
      if (!job && is_damage(job.error(), id)) continue;
      if (!job) return tl::make_unexpected(job.error());
      page.jobs.push_back(std::move(*job));
    }
    if (more) page.next = ids.back();
    return page;
  });
}

Result<bool> SqlStore::has_text(Database& db, const std::string& id, const std::u32string& folded_text) {
  if (folded(id).find(folded_text) != std::u32string::npos) return true;
  Query query(db, "SELECT reference, note FROM job WHERE id=?", id);
  VACUFORM_TRY(found, query.row());
  return found && (folded(query.text(0)).find(folded_text) != std::u32string::npos ||
                   folded(query.text(1)).find(folded_text) != std::u32string::npos);
}

Result<std::optional<Job>> SqlStore::newest_inspection(const StoredScan& scan) {
  return read([&](Database& db) -> Result<std::optional<Job>> {
    Query query(
        db,
        "SELECT job.id FROM input JOIN job ON job.id=input.job WHERE input.blob=? AND input.name='scan'"
        " AND input.extension=? AND job.kind='inspection' AND job.owner=? ORDER BY job.id DESC LIMIT 1",
        scan.blob.sha256, scan.extension, scan.owner);
    VACUFORM_TRY(found, query.row());
    if (!found) return std::optional<Job>();
    VACUFORM_TRY(job, find(db, query.text(0)));
    return std::optional(std::move(job));
  });
}

Result<Job> SqlStore::cancel(const std::string& id, const JobGuard& allowed) {
  const Deletion deletion(*this);
  return write([&](Transaction& tx) -> Result<Job> {
    VACUFORM_TRY(row, find_row(tx.db, id, Lock::yes, Detail::full));
    if (allowed && !allowed(row.job))
      return fail(Code::conflict, "the job has changed", id, "look at it again");
    VACUFORM_TRY(next, when_cancel_asked(row.job, row.faults));
    VACUFORM_CHECK(apply(tx, row, next));
    return std::move(row.job);
  });
}

Result<void> SqlStore::remove(const std::string& id, const JobGuard& allowed) {
  const Deletion deletion(*this);
  const auto removed = write([&](Transaction& tx) -> Result<void> {
    VACUFORM_TRY(row, find_row(tx.db, id, Lock::yes, Detail::full));
    if (allowed && !allowed(row.job))
      return fail(Code::conflict, "the job has changed", id, "look at it again");
    VACUFORM_CHECK(may_be_deleted(row.job));
    for (const auto& input : row.job.inputs) tx.garbage.push_back(input.blob.sha256);
    VACUFORM_CHECK(drop_artifacts(tx, row));
    tx.changed.push_back(id);  // waiting clients learn that it is gone
    return Query(tx.db, "DELETE FROM job WHERE id=?", id).run();
  });
  if (removed) forget_deleted();
  return removed;
}

Result<std::vector<LogLine>> SqlStore::log_after(const std::string& id, std::int64_t number, int limit) {
  return read([&](Database& db) -> Result<std::vector<LogLine>> {
    VACUFORM_CHECK(find(db, id, Detail::brief));
    Query query(db, "SELECT number, time, text FROM job_log WHERE job=? AND number>? ORDER BY number LIMIT ?",
                id, number, std::clamp(limit, 1, 1000));
    std::vector<LogLine> lines;
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return lines;
      lines.push_back({query.integer(0), query.integer(1), query.text(2)});
    }
  });
}

Result<Job> SqlStore::wait_for_change(const std::string& id, std::int64_t version,
                                      std::chrono::milliseconds time) {
  Result<Job> seen = fail(Code::busy, "too many clients wait for changes of jobs", id, "ask again later");
  notifications_.wait(id, time, [&] {
    seen = job(id);
    return !seen || seen->version > version;
  });
  return seen;
}

}  // namespace vacuform
