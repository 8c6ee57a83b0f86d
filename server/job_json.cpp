#include "server/job_json.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/problem.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

// Where each stage begins in the progress of the whole, by the seconds that they take on a head at default
// settings. An inspection has the first and the last of them.
using StageBegins = std::array<double, stage_names.size() + 1>;
constexpr StageBegins of_print{0, 0.1, 0.55, 0.65, 0.8, 1}, of_inspection{0, 0.7, 0.7, 0.7, 0.7, 1};

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
  const StageBegins& stage_begins = job.kind == JobKind::print ? of_print : of_inspection;
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

ordered_json log_line_json(const LogLine& line) {
  return {{"number", line.number}, {"time", rfc3339(line.time)}, {"text", line.text}};
}

ordered_json inputs_json(const Job& job) {
  ordered_json inputs = ordered_json::object();
  for (const Input& input : job.inputs) inputs[input.name] = input_json(input);
  return inputs;
}

ordered_json job_json(const Job& job) {
  const std::string self = "/api/v1/jobs/" + job.id;
  ordered_json artifacts = ordered_json::array();
  for (const auto& artifact : job.artifacts) artifacts.push_back(artifact_json(job, artifact));
  return {{"id", job.id},
          {"kind", name(job.kind)},
          {"state", name(job.state)},
          {"stage", job.stage ? ordered_json(name(*job.stage)) : ordered_json()},
          {"progress", rounded(whole_progress(job))},
          {"stage_progress", rounded(job.stage_progress)},
          {"attempt", job.attempt},
          {"priority", job.priority},
          {"derived_from", job.derived_from ? ordered_json(*job.derived_from) : ordered_json()},
          {"version", job.version},
          {"created", rfc3339(job.created)},
          {"started", time_or_null(job.started)},
          {"ended", time_or_null(job.ended)},
          {"not_before", time_or_null(job.not_before)},
          {"settings", ordered_json::parse(job.settings)},
          {"inputs", inputs_json(job)},
          {"artifacts", artifacts},
          {"problem", job.error ? problem_json(*job.error) : ordered_json()},
          {"links",
           {{"self", self},
            {"page", "/jobs/" + job.id},
            {"artifacts", self + "/artifacts"},
            {"zip", self + "/artifacts.zip"},
            {"log", self + "/log"},
            {"cancel", self + "/cancel"}}}};
}

}  // namespace vacuform
