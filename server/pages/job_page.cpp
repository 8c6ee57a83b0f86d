#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>

#include "server/jobs/job_json.hpp"
#include "server/pages/findings_html.hpp"
#include "server/pages/pages.hpp"

namespace vacuform {

using nlohmann::json;

namespace {

std::string progress_html(const Job& job) {
  const int percent = static_cast<int>(100 * whole_progress(job));
  std::string text = "Waiting for a worker.";
  if (job.state == JobState::running)
    text = job.stage ? "Stage: " + std::string(name(*job.stage)) + "." : "A worker has taken the job.";
  if (job.state == JobState::cancelling) text = "The worker is told to stop.";
  if (job.attempt > 1) text += " Attempt " + std::to_string(job.attempt) + ".";
  return "<p id=\"progress-text\">" + escaped(text) + " " + std::to_string(percent) +
         " % done. This page follows by itself.</p>\n<progress max=\"100\" value=\"" +
         std::to_string(percent) + "\" aria-labelledby=\"progress-text\" data-events=\"/api/v1/jobs/" +
         escaped(job.id) + "/events\">" + std::to_string(percent) + " %</progress>\n";
}

// "6 of 19 coils and 41 % of the drawing's ink lie on the head."
std::string on_head_html(const json& report) {
  const json &coils = at(report, {"coils"}), &ink = at(report, {"pattern", "ink_on_head"});
  if (!ink.is_number()) return "";
  const std::string share = number(100 * ink.get<double>(), 1) + " % of the drawing's ink";
  if (!coils.is_array() || coils.empty()) return "<p>" + share + " lies on the head.</p>\n";
  const json& on_head = at(report, {"figures", "with", "coils", "on_head"});
  return "<p>" + (on_head.is_number() ? number(on_head, 0) : std::string("0")) + " of " +
         std::to_string(coils.size()) + " coils and " + share + " lie on the head.</p>\n";
}

std::string figures_html(const json& report) {
  const json& figures = at(report, {"figures"});
  if (!figures.is_object()) return "";
  std::string html =
      "<h2>Figures</h2>\n" + on_head_html(report) +
      "<div class=\"wide\"><table>\n<caption>Distortion of the pattern on the formed part, "
      "over the inked "
      "surface; "
      "1 is none</caption>\n<thead><tr><th scope=\"col\">Figure</th><th scope=\"col\">Print</th>"
      "<th scope=\"col\" class=\"number\">Mean</th><th scope=\"col\" class=\"number\">95 %</th><th "
      "scope=\"col\" class=\"number\">99 %</th><th "
      "scope=\"col\">Worst</th></tr>"
      "</thead>\n<tbody>\n";
  for (const auto& [key, title] :
       {std::pair{"anisotropy", "Shape (anisotropy)"}, std::pair{"area_ratio", "Area ratio"}})
    for (const auto& [which, print] :
         {std::pair{"without", "plain pattern"}, std::pair{"with", "pre-distorted"}}) {
      html += std::string("<tr><th scope=\"row\">") + title + "</th><td>" + print + "</td>";
      for (const char* column : {"mean", "p95", "p99", "max"})
        html += "<td class=\"number\">" + number(at(figures, {which, key, column})) + "</td>";
      html += "</tr>\n";
    }
  return html + "</tbody>\n</table></div>\n";
}

// Where a warning applies, by the numbers that preview-findings.png shows.
std::string places_html(const json& marks) {
  if (!marks.is_array() || marks.empty()) return "";
  std::string html =
      "<details>\n<summary>Places</summary>\n<div class=\"wide\"><table>\n<thead><tr><th "
      "scope=\"col\">No.</th>";
  for (const char* column : {"x, mm", "y, mm", "z, mm", "size, mm"})
    html += std::string("<th scope=\"col\" class=\"number\">") + column + "</th>";
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const json& place = at(marks[i], {"place_mm"});
    html += "<tr><th scope=\"row\">" + std::to_string(i + 1) + "</th>";
    for (std::size_t k = 0; k < 3; ++k)
      html += "<td class=\"number\">" +
              (place.is_array() && k < place.size() ? number(place[k], 1) : std::string("-")) + "</td>";
    html += "<td class=\"number\">" + number(at(marks[i], {"size_mm"}), 1) + "</td></tr>\n";
  }
  return html + "</tbody>\n</table></div>\n</details>\n";
}

// The report was made by a sandboxed program: its words choose no class.
bool is_severity(const std::string& text) { return text == "note" || text == "warning" || text == "serious"; }

std::string warnings_html(const json& report) {
  const json& warnings = at(report, {"warnings"});
  if (!warnings.is_array() || warnings.empty()) return "";
  std::string html = "<h2>Warnings</h2>\n<ul class=\"warnings\">\n";
  for (const json& warning : warnings) {
    const json& what = at(warning, {"what"});
    if (!what.is_string()) continue;
    const auto text = [&](const char* key) {
      const json& value = at(warning, {key});
      return value.is_string() ? value.get<std::string>() : std::string();
    };
    const std::string severity = is_severity(text("severity")) ? text("severity") : "warning";
    html += "<li class=\"" + severity + "\"><strong>" + severity + "</strong> " + escaped(text("what"));
    if (!text("place").empty()) html += "<br>Where: " + escaped(text("place")) + ".";
    if (!text("fix").empty()) html += "<br>Fix: " + escaped(text("fix"));
    html += places_html(at(warning, {"marks"})) + "</li>\n";
  }
  return html + "</ul>\n";
}

std::string previews_html(const Job& job) {
  std::string html;
  for (const auto& artifact : job.artifacts) {
    const ArtifactKind* kind = artifact_kind(artifact.name);
    if (!kind || !artifact.name.starts_with("preview-")) continue;
    const std::string href = "/api/v1/jobs/" + escaped(job.id) + "/artifacts/" + escaped(artifact.name);
    html += "<figure><a href=\"" + href + "\"><img src=\"" + href + "\" alt=\"" + escaped(kind->title) +
            "\" loading=\"lazy\"></a><figcaption>" + escaped(kind->title) + "</figcaption></figure>\n";
  }
  return html.empty() ? "" : "<h2>Previews</h2>\n<div class=\"previews\">\n" + html + "</div>\n";
}

std::string downloads_html(const Job& job) {
  if (job.artifacts.empty()) return "";
  const std::string base = "/api/v1/jobs/" + escaped(job.id);
  std::string html =
      "<h2>Downloads</h2>\n<p><a class=\"button\" href=\"" + base +
      "/artifacts.zip\" download>All files (zip)</a></p>\n<div class=\"wide\"><table>\n<thead><tr><th "
      "scope=\"col\">File</th>"
      "<th scope=\"col\">What it is</th><th scope=\"col\" class=\"number\">Size</th></tr></thead>\n<tbody>\n";
  for (const auto& artifact : job.artifacts) {
    const ArtifactKind* kind = artifact_kind(artifact.name);
    html += "<tr><th scope=\"row\"><a href=\"" + base + "/artifacts/" + escaped(artifact.name) +
            "\" download>" + escaped(artifact.name) + "</a></th><td>" + escaped(kind ? kind->title : "") +
            "</td><td class=\"number\">" + readable_bytes(artifact.blob.bytes) + "</td></tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string button_html(const Job& job, const char* action, const char* label) {
  return "<form method=\"post\" action=\"/jobs/" + escaped(job.id) + "/" + action +
         "\"><button type=\"submit\">" + label + "</button></form>\n";
}

std::string facts_html(const Job& job) {
  const auto row = [](const std::string& key, const std::string& value) {
    return "<dt>" + key + "</dt><dd>" + value + "</dd>\n";
  };
  const auto file = [](const Input& input) {
    return escaped(input.extension.empty() ? "file" : input.extension) + ", " +
           readable_bytes(input.blob.bytes);
  };
  std::string html = "<h2>This job</h2>\n<dl>\n" + row("Job", "<code>" + escaped(job.id) + "</code>") +
                     row("Created", rfc3339(job.created));
  for (const Input& input : job.inputs)
    if (const InputKind* kind = input_kind(input.name)) html += row(escaped(kind->title), file(input));
  if (job.derived_from) {
    const std::string from = escaped(*job.derived_from);
    html += row("Begun with", "<a href=\"/jobs/" + from + "\"><code>" + from + "</code></a>");
  }
  if (job.priority != 0) html += row("Priority", std::to_string(job.priority));
  if (job.ended && job.started) {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f s", static_cast<double>(*job.ended - *job.started) / 1000);
    html += row("Took", seconds);
  }
  const json settings = json::parse(job.settings, nullptr, false);
  return html + "</dl>\n<details>\n<summary>Settings</summary>\n<pre>" + escaped(settings.dump(2)) +
         "</pre>\n</details>\n";
}

std::string log_html(const std::vector<LogLine>& log) {
  if (log.empty()) return "";
  std::string html = "<details>\n<summary>Log</summary>\n<ol>\n";
  for (const LogLine& line : log)
    html += "<li><time datetime=\"" + rfc3339(line.time) + "\">" + rfc3339(line.time).substr(11, 8) +
            "</time> " + escaped(line.text) + "</li>\n";
  return html + "</ol>\n</details>\n";
}

}  // namespace

std::string serious_html(const Job& job) {
  const int count = job.serious_warnings.value_or(0);
  if (count == 0) return "";
  return " <span class=\"state serious\">with " + std::to_string(count) + " serious warning" +
         (count == 1 ? "" : "s") + "</span>";
}

Page job_page(const Job& job, const json& made, const std::vector<LogLine>& log) {
  Page page;
  const std::string state(name(job.state));
  const std::string what = job.kind == JobKind::print ? "Job" : "Inspection";
  page.title = what + " " + state + (job.serious_warnings.value_or(0) > 0 ? " with serious warnings" : "");
  page.signed_in = true;
  page.main = "<h1>" + what + " <span class=\"state " + state + "\">" + state + "</span>" +
              serious_html(job) + "</h1>\n";
  if (!ended(job.state)) {
    page.refresh_seconds = 2;
    page.follows = true;
    page.main += progress_html(job);
  }
  if (job.error) page.main += problem_box(*job.error);
  if (job.kind == JobKind::inspection) page.main += findings_html(made);
  page.main += warnings_html(made) + previews_html(job) + figures_html(made);
  if (job.kind == JobKind::print) page.main += findings_html(made);
  page.main += print_form_html(job) + downloads_html(job) + facts_html(job) + log_html(log);
  page.main += "<div class=\"actions\">\n";
  if (job.state == JobState::queued || job.state == JobState::running)
    page.main += button_html(job, "cancel", "Cancel this job");
  if (ended(job.state)) page.main += button_html(job, "delete", "Delete this job and its files");
  page.main += "<p><a href=\"/\">New job</a></p>\n</div>\n";
  return page;
}

}  // namespace vacuform
