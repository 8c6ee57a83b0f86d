#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/jobs/job_json.hpp"
#include "server/pages/findings.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

// "Number 3 in the queue. Such a job usually takes 2 minutes."
std::string estimate_text(const Estimate& estimate) {
  std::string text;
  if (estimate.queue_position)
    text += "Number " + std::to_string(*estimate.queue_position) + " in the queue.";
  if (!estimate.seconds_expected) return text;
  const auto seconds = static_cast<int>(std::ceil(*estimate.seconds_expected));
  const int minutes = (seconds + 30) / 60;
  return text + (text.empty() ? "" : " ") + "Such a job usually takes " +
         (seconds < 90 ? std::to_string(seconds) + " seconds" : std::to_string(minutes) + " minutes") + ".";
}

ordered_json progress_values(const Job& job, const Estimate& estimate) {
  if (ended(job.state)) return nullptr;
  std::string text = "Waiting for a worker.";
  if (job.state == JobState::running)
    text = job.stage ? "Stage: " + std::string(name(*job.stage)) + "." : "A worker has taken the job.";
  if (job.state == JobState::cancelling) text = "The worker is told to stop.";
  if (job.attempt > 1) text += " Attempt " + std::to_string(job.attempt) + ".";
  return {{"text", text},
          {"estimate", estimate_text(estimate)},
          {"percent", std::to_string(static_cast<int>(100 * whole_progress(job)))}};
}

// "6 of 19 coils and 41 % of the drawing's ink lie on the head."
ordered_json on_head_values(const json& report) {
  const json &coils = at(report, {"coils"}), &ink = at(report, {"pattern", "ink_on_head"});
  if (!ink.is_number()) return nullptr;
  ordered_json values = {{"ink", number(100 * ink.get<double>(), 1)}, {"coils", nullptr}};
  if (!coils.is_array() || coils.empty()) return values;
  const json& on_head = at(report, {"figures", "with", "coils", "on_head"});
  values["coils"] = {{"some", on_head.is_number() ? number(on_head, 0) : "0"},
                     {"all", std::to_string(coils.size())}};
  return values;
}

ordered_json figures_values(const json& report) {
  const json& figures = at(report, {"figures"});
  if (!figures.is_object()) return nullptr;
  ordered_json rows = ordered_json::array();
  for (const auto& [key, title] :
       {std::pair{"shape", "Shape distortion"}, std::pair{"area", "Area distortion"}})
    for (const auto& [which, print] :
         {std::pair{"without", "plain pattern"}, std::pair{"with", "pre-distorted"}}) {
      ordered_json numbers = ordered_json::array();
      for (const char* column : {"mean", "p95", "p99", "max"})
        numbers.push_back(number(at(figures, {which, key, column})));
      rows.push_back({{"title", title}, {"print", print}, {"numbers", std::move(numbers)}});
    }
  return {{"on_head", on_head_values(report)}, {"rows", std::move(rows)}};
}

// Where a warning applies, by the numbers that preview-findings.png shows.
ordered_json places_values(const json& marks) {
  if (!marks.is_array() || marks.empty()) return nullptr;
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const json& place = at(marks[i], {"place_mm"});
    ordered_json figures = ordered_json::array();
    for (std::size_t k = 0; k < 3; ++k)
      figures.push_back(place.is_array() && k < place.size() ? number(place[k], 1) : "-");
    figures.push_back(number(at(marks[i], {"size_mm"}), 1));
    rows.push_back({{"number", std::to_string(i + 1)}, {"figures", std::move(figures)}});
  }
  return {{"marks", std::move(rows)}};
}

// The report was made by a sandboxed program: its words choose no class.
bool is_severity(const std::string& text) { return text == "note" || text == "warning" || text == "serious"; }

ordered_json warnings_values(const json& report) {
  const json& warnings = at(report, {"warnings"});
  if (!warnings.is_array() || warnings.empty()) return nullptr;
  ordered_json list = ordered_json::array();
  for (const json& warning : warnings) {
    if (!at(warning, {"what"}).is_string()) continue;
    const std::string severity = text(at(warning, {"severity"}));
    list.push_back({{"severity", is_severity(severity) ? severity : "warning"},
                    {"what", text(at(warning, {"what"}))},
                    {"place", text(at(warning, {"place"}), "")},
                    {"fix", text(at(warning, {"fix"}), "")},
                    {"places", places_values(at(warning, {"marks"}))}});
  }
  return {{"list", std::move(list)}};
}

ordered_json files_values(const Job& job, bool previews) {
  ordered_json files = ordered_json::array();
  for (const auto& artifact : job.artifacts) {
    const ArtifactKind* kind = artifact_kind(artifact.name);
    if (previews && (!kind || !artifact.name.starts_with("preview-"))) continue;
    files.push_back({{"name", artifact.name},
                     {"title", kind ? kind->title : ""},
                     {"size", readable_bytes(artifact.blob.bytes)}});
  }
  if (files.empty()) return nullptr;
  return {{"files", std::move(files)}};
}

const char* title_of(JobKind kind) {
  switch (kind) {
    case JobKind::print:
      return "Job";
    case JobKind::inspection:
      return "Inspection";
    case JobKind::layout:
      break;
  }
  return "Layout";
}

ordered_json inputs_values(const Job& job) {
  ordered_json inputs = ordered_json::array();
  for (const Input& input : job.inputs)
    if (const InputKind* kind = input_kind(input.name))
      inputs.push_back({{"title", kind->title},
                        {"extension", input.extension.empty() ? "file" : input.extension},
                        {"size", readable_bytes(input.blob.bytes)}});
  return inputs;
}

// The reference on the print, if it is no longer that of the job.
ordered_json printed_reference_values(const Job& job) {
  if (job.kind != JobKind::print || !job.started) return nullptr;
  const std::string printed = reference_at(job, *job.started);
  if (printed == job.reference) return nullptr;
  return {{"text", printed.empty() ? "No reference" : printed}};
}

std::string seconds_text(const Job& job) {
  if (!job.ended || !job.started) return "";
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, "%.1f", static_cast<double>(*job.ended - *job.started) / 1000);
  return seconds;
}

ordered_json log_values(const std::vector<LogLine>& log) {
  if (log.empty()) return nullptr;
  ordered_json lines = ordered_json::array();
  for (const LogLine& line : log) {
    const std::string time = rfc3339(line.time);
    lines.push_back({{"time", time}, {"clock", time.substr(11, 8)}, {"text", line.text}});
  }
  return {{"lines", std::move(lines)}};
}

}  // namespace

std::string serious_text(const Job& job) {
  const int count = job.serious_warnings.value_or(0);
  if (count == 0) return "";
  return std::to_string(count) + " serious warning" + (count == 1 ? "" : "s");
}

Page job_page(const Job& job, const json& made, const std::vector<LogLine>& log, const Estimate& estimate) {
  const std::string state(name(job.state));
  const std::string what = title_of(job.kind);
  Page page;
  page.title = what + " " + state + (job.serious_warnings.value_or(0) > 0 ? " with serious warnings" : "");
  page.signed_in = true;
  page.follows = !ended(job.state);
  if (page.follows) page.refresh_seconds = 2;
  page.main =
      rendered("job", {{"id", job.id},
                       {"what", what},
                       {"state", state},
                       {"serious", serious_text(job)},
                       {"inspection", job.kind == JobKind::inspection},
                       {"progress", progress_values(job, estimate)},
                       {"problem", problem_values(job.error)},
                       {"findings", findings_values(made)},
                       {"layout", layout_values(made)},
                       {"warnings", warnings_values(made)},
                       {"previews", files_values(job, true)},
                       {"figures", figures_values(made)},
                       {"downloads", files_values(job, false)},
                       {"created", rfc3339(job.created)},
                       {"reference", job.reference},
                       {"printed_reference", printed_reference_values(job)},
                       {"reference_changes", reference_changes_json(job)},
                       {"note", job.note},
                       {"inputs", inputs_values(job)},
                       {"derived_from", job.derived_from.value_or("")},
                       {"priority", job.priority != 0 ? std::to_string(job.priority) : ""},
                       {"seconds", seconds_text(job)},
                       {"settings", json::parse(job.settings, nullptr, false).dump(2)},
                       {"log", log_values(log)},
                       {"can_cancel", job.state == JobState::queued || job.state == JobState::running},
                       {"can_delete", ended(job.state)}});
  return page;
}

}  // namespace vacuform
