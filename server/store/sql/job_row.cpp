// The rows of jobs, their files and their logs.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/utf8.hpp"
#include "api/problem.hpp"
#include "server/store/sql/sql_store.hpp"
#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

namespace {

#define VACUFORM_JOB_COLUMNS                                                                               \
  "SELECT id, state, stage, progress, attempt, created, started, ended, error_code, error_what,"           \
  " error_where, error_fix, request, owner, priority, derived_from, not_before, version, kind, settings,"  \
  " serious_warnings, reference, note, losses, crashes, worker, lease_hash, log_lines, reference_changes," \
  " error_proposals"                                                                                       \
  " FROM job WHERE id=?"

constexpr const char* job_row = VACUFORM_JOB_COLUMNS;
constexpr const char* locked_job_row = VACUFORM_JOB_COLUMNS " FOR UPDATE";

#undef VACUFORM_JOB_COLUMNS

Result<std::vector<Input>> inputs_in(Query& query) {
  std::vector<Input> inputs;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    inputs.push_back(
        {query.text(0), {query.text(1), static_cast<std::uint64_t>(query.integer(2))}, query.text(3)});
  }
  sort_inputs(inputs);
  return inputs;
}

Result<std::vector<StoredArtifact>> artifacts_in(Query& query) {
  std::vector<StoredArtifact> artifacts;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    artifacts.push_back({query.text(0), {query.text(1), static_cast<std::uint64_t>(query.integer(2))}});
  }
  std::sort(artifacts.begin(), artifacts.end(), [](const StoredArtifact& a, const StoredArtifact& b) {
    return artifact_kind(a.name) < artifact_kind(b.name);  // index in one table
  });
  return artifacts;
}

tl::unexpected<Error> damaged_row(const std::string& id) {
  return fail(Code::internal, "the row of this job is damaged", id, damage_fix);
}

std::optional<Millis> time_in(const Query& query, int column) {
  if (query.null(column)) return std::nullopt;
  return query.integer(column);
}

}  // namespace

Result<SqlStore::JobRow> SqlStore::find_row(Database& db, const std::string& id, Lock lock, Detail detail) {
  Query query(db, lock == Lock::yes ? locked_job_row : job_row, id);
  Query inputs(db, "SELECT name, blob, bytes, extension FROM input WHERE job=?", id);
  Query artifacts(db, "SELECT name, blob, bytes FROM artifact WHERE job=?", id);
  query.send();
  if (detail == Detail::full) inputs.send(), artifacts.send();
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such job", id, "see the list of jobs");
  const auto state = job_state_from(query.text(1));
  const auto kind = job_kind_from(query.text(18));
  if (!state || !kind) return damaged_row(id);
  JobRow row;
  Job& job = row.job;
  job.id = query.text(0);
  job.kind = *kind;
  job.state = *state;
  job.stage = stage_from(query.text(2));
  job.stage_progress = query.real(3);
  job.attempt = static_cast<int>(query.integer(4));
  job.created = query.integer(5);
  job.started = time_in(query, 6);
  job.ended = time_in(query, 7);
  if (!query.null(8)) {
    job.error = Error{code_from(query.text(8)).value_or(Code::internal), query.text(9), query.text(10),
                      query.text(11)};
    if (!query.null(29))
      job.error->proposals = proposals_from(nlohmann::json::parse(query.text(29), nullptr, false))
                                 .value_or(std::vector<Proposal>());
  }
  job.request = query.text(12);
  job.owner = query.text(13);
  job.priority = static_cast<int>(query.integer(14));
  if (!query.null(15)) job.derived_from = query.text(15);
  job.not_before = time_in(query, 16);
  job.version = query.integer(17);
  job.settings = query.text(19);
  if (!query.null(20)) job.serious_warnings = static_cast<int>(query.integer(20));
  job.reference = query.text(21);
  job.note = query.text(22);
  row.faults = {static_cast<int>(query.integer(23)), static_cast<int>(query.integer(24))};
  row.worker = query.text(25);
  row.lease_hash = query.text(26);
  row.log_lines = query.integer(27);
  job.reference_changes = query.text(28);
  for (const std::string* text : {&job.request, &job.owner, &job.reference, &job.note, &row.worker})
    if (!code_points(*text)) return damaged_row(id);
  if (job.error)
    for (const std::string* text : {&job.error->what, &job.error->where, &job.error->fix})
      if (!code_points(*text)) return damaged_row(id);
  if (detail == Detail::full) {
    if (!nlohmann::json::accept(job.settings)) return damaged_row(id);
    VACUFORM_TRY(given, inputs_in(inputs));
    VACUFORM_TRY(stored, artifacts_in(artifacts));
    job.inputs = std::move(given);
    row.stored = std::move(stored);
    if (ended(job.state)) job.artifacts = row.stored;
  }
  return row;
}

bool SqlStore::is_damage(const Error& error, const std::string& id) {
  if (error.code != Code::internal || error.fix != damage_fix) return false;
  const std::lock_guard hold(damage_mutex_);
  if (damaged_jobs_.insert(id).second) log_event("row-damaged", {{"job", id}, {"problem", error.what}});
  return true;
}

Result<Job> SqlStore::find(Database& db, const std::string& id, Detail detail) {
  VACUFORM_TRY(row, find_row(db, id, Lock::no, detail));
  if (detail == Detail::brief) row.job.settings.clear();
  return std::move(row.job);
}

Result<void> SqlStore::save(Transaction& tx, JobRow& row) {
  Job& job = row.job;
  ++job.version;
  std::optional<std::string_view> stage, code, what, where, fix;
  std::optional<std::string> proposals;
  if (job.stage) stage = name(*job.stage);
  if (const auto& error = job.error)
    code = meaning(error->code).slug, what = error->what, where = error->where, fix = error->fix,
    proposals = proposals_json(error->proposals).dump();
  const auto text = [](const std::string& value) {
    return value.empty() ? std::nullopt : std::optional<std::string_view>(value);
  };
  tx.changed.push_back(job.id);
  return Query(tx.db,
               "UPDATE job SET state=?, stage=?, progress=?, attempt=?, losses=?, crashes=?, started=?, "
               "ended=?,"
               " not_before=?, worker=?, lease_hash=?, log_lines=?, serious_warnings=?, error_code=?,"
               " error_what=?, error_where=?, error_fix=?, error_proposals=?, version=? WHERE id=?",
               name(job.state), stage, job.stage_progress, job.attempt, row.faults.losses, row.faults.crashes,
               job.started, job.ended, job.not_before, text(row.worker), text(row.lease_hash), row.log_lines,
               job.serious_warnings, code, what, where, fix, proposals, job.version, job.id)
      .run();
}

Result<void> SqlStore::add_line(Database& db, const std::string& job, std::string_view text) {
  return Query(db,
               "INSERT INTO job_log(job, number, time, text) VALUES(?1,"
               " (SELECT coalesce(max(number), 0) + 1 FROM job_log WHERE job=?1), ?2, ?3)",
               job, options_.clock(), text)
      .run();
}

// The hash of the lease stays with a job that a worker has ended, so that a repeated request with the same token gets
// the same answer. Only a job that has succeeded keeps all artifacts: an incomplete set is useless, except for what
// explains a failure.
Result<void> SqlStore::apply(Transaction& tx, JobRow& row, const Transition& next) {
  if (!next.changes) return {};
  Job& job = row.job;
  job.state = next.state;
  job.attempt = next.attempt;
  row.faults = next.faults;
  if (next.state == JobState::queued || (ended(next.state) && next.state != JobState::succeeded))
    VACUFORM_CHECK(drop_artifacts(tx, row, next.explained));
  if (next.state == JobState::queued) {
    job.stage.reset(), job.started.reset(), job.not_before.reset();
    job.stage_progress = 0;
    row.worker.clear();
    if (next.rest) {
      VACUFORM_TRY(now, lease_times().now(tx.db));
      job.not_before = now + *next.rest;
    }
  }
  if (ended(next.state)) {
    job.ended = options_.clock();
    job.error = next.error;
    tx.ended.push_back(job);
  }
  if (next.forgets_lease) row.lease_hash.clear();
  if (next.state == JobState::queued || ended(next.state)) VACUFORM_CHECK(lease_times().ended(tx.db, job.id));
  VACUFORM_CHECK(save(tx, row));
  return add_line(tx.db, job.id, next.line);
}

Result<void> SqlStore::drop_artifacts(Transaction& tx, JobRow& row, bool but_explaining) {
  std::vector<StoredArtifact> kept;
  for (const auto& artifact : row.stored) {
    const ArtifactKind* kind = artifact_kind(artifact.name);
    if (but_explaining && kind && explains_failure(row.job.kind, *kind)) {
      kept.push_back(artifact);
      continue;
    }
    tx.garbage.push_back(artifact.blob.sha256);
    VACUFORM_CHECK(
        Query(tx.db, "DELETE FROM artifact WHERE job=? AND name=?", row.job.id, artifact.name).run());
  }
  row.job.artifacts = row.stored = kept;
  return {};
}

}  // namespace vacuform
