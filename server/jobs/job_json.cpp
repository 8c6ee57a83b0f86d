#include "server/jobs/job_json.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/messages/problem.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

// Where each stage begins in the progress of the whole, by the seconds that they take on a head at default
// settings. An inspection has the first and the last of them, a layout all but the last.
using StageBegins = std::array<double, stage_names.size() + 1>;
constexpr StageBegins of_print{0, 0.1, 0.55, 0.65, 0.8, 1}, of_inspection{0, 0.7, 0.7, 0.7, 0.7, 1},
    of_layout{0, 0.1, 0.6, 0.7, 1, 1};

const StageBegins& stage_begins_of(JobKind kind) {
  switch (kind) {
    case JobKind::print:
      return of_print;
    case JobKind::inspection:
      return of_inspection;
    case JobKind::layout:
      break;
  }
  return of_layout;
}

ordered_json time_or_null(const std::optional<Millis>& time) {
  return time ? ordered_json(rfc3339(*time)) : ordered_json();
}

// Four digits: a progress bar needs no more, and 0.34 reads better than 0.33999999999999997.
double rounded(double progress) { return std::round(progress * 1e4) / 1e4; }

}  // namespace

std::string etag_of(const Job& job) {
  std::string tag("\"");
  return tag.append(std::to_string(job.version)).append("\"");
}

double whole_progress(const Job& job) {
  if (job.state == JobState::succeeded) return 1;
  if (!job.stage) return 0;
  const auto stage = static_cast<std::size_t>(*job.stage);
  const StageBegins& stage_begins = stage_begins_of(job.kind);
  return stage_begins[stage] + job.stage_progress * (stage_begins[stage + 1] - stage_begins[stage]);
}

ordered_json input_json(const Input& input) {
  return {{"bytes", input.blob.bytes}, {"sha256", input.blob.sha256}, {"extension", input.extension}};
}

ordered_json artifact_json(const Job& job, const StoredArtifact& artifact) {
  const ArtifactKind* kind = artifact_kind(artifact.name);
  return {{"name", artifact.name},
          {"title", kind ? kind->title : ""},
          {"media_type", kind ? kind->media_type : "application/octet-stream"},
          {"bytes", artifact.blob.bytes},
          {"sha256", artifact.blob.sha256},
          {"href", "/api/v1/jobs/" + job.id + "/artifacts/" + artifact.name}};
}

ordered_json backup_json(const BackupReport& report) {
  return {{"jobs", report.jobs}, {"files", report.blobs}, {"damaged", report.damaged}};
}

ordered_json orphans_json(const OrphanReport& report) {
  return {{"objects", report.objects},
          {"orphans", report.orphans},
          {"bytes", report.bytes},
          {"oldest", report.oldest ? ordered_json(rfc3339(*report.oldest)) : ordered_json()},
          {"deleted", report.deleted}};
}

ordered_json log_line_json(const LogLine& line) {
  return {{"number", line.number}, {"time", rfc3339(line.time)}, {"text", line.text}};
}

ordered_json inputs_json(const Job& job) {
  ordered_json inputs = ordered_json::object();
  for (const Input& input : job.inputs) inputs[input.name] = input_json(input);
  return inputs;
}

ordered_json reference_changes_json(const Job& job) {
  ordered_json changes = ordered_json::array();
  if (job.reference_changes.empty()) return changes;
  changes = ordered_json::parse(job.reference_changes);
  for (ordered_json& change : changes) change["time"] = rfc3339(change["time"].get<Millis>());
  return changes;
}

ordered_json job_json(const Job& job, Detail detail) {
  ordered_json all = ordered_json::object();
  // One by one: a list of braces would make each value twice, and lists show many jobs.
  all.get_ref<ordered_json::object_t&>().reserve(24);
  all["id"] = job.id;
  all["kind"] = name(job.kind);
  all["state"] = name(job.state);
  all["stage"] = job.stage ? ordered_json(name(*job.stage)) : ordered_json();
  all["progress"] = rounded(whole_progress(job));
  all["stage_progress"] = rounded(job.stage_progress);
  all["attempt"] = job.attempt;
  all["priority"] = job.priority;
  all["owner"] = job.owner;
  all["reference"] = job.reference;
  all["note"] = job.note;
  all["derived_from"] = job.derived_from ? ordered_json(*job.derived_from) : ordered_json();
  all["version"] = job.version;
  all["created"] = rfc3339(job.created);
  all["started"] = time_or_null(job.started);
  all["ended"] = time_or_null(job.ended);
  all["not_before"] = time_or_null(job.not_before);
  all["serious_warnings"] = job.serious_warnings ? ordered_json(*job.serious_warnings) : ordered_json();
  all["problem"] = job.error ? problem_json(*job.error) : ordered_json();
  if (detail == Detail::brief) return all;
  all["settings"] = ordered_json::parse(job.settings);
  all["inputs"] = inputs_json(job);
  ordered_json& artifacts = all["artifacts"] = ordered_json::array();
  for (const auto& artifact : job.artifacts) artifacts.push_back(artifact_json(job, artifact));
  all["reference_changes"] = reference_changes_json(job);
  all["printed_reference"] = job.kind == JobKind::print && job.started
                                 ? ordered_json(reference_at(job, *job.started))
                                 : ordered_json();
  const std::string self = "/api/v1/jobs/" + job.id;
  all["links"] = {{"self", self},
                  {"page", "/jobs/" + job.id},
                  {"artifacts", self + "/artifacts"},
                  {"zip", self + "/artifacts.zip"},
                  {"log", self + "/log"},
                  {"cancel", self + "/cancel"}};
  return all;
}

ordered_json job_json(const Job& job, const Estimate& estimate) {
  ordered_json all = job_json(job);
  all["queue_position"] = estimate.queue_position ? ordered_json(*estimate.queue_position) : ordered_json();
  all["seconds_expected"] = estimate.seconds_expected
                                ? ordered_json(std::round(*estimate.seconds_expected * 10) / 10)
                                : ordered_json();
  return all;
}

}  // namespace vacuform
