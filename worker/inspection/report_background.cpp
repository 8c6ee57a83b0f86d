// The sections of report.html behind the figures: what was formed and how, and everything needed to repeat it.
#include "api/settings.hpp"
#include "worker/inspection/html.hpp"
#include "worker/inspection/report_sections.hpp"

namespace vacuform {

namespace {

using Facts = std::vector<std::pair<std::string, std::string>>;

std::string sizes(const ReportJson& values, int places, const std::string& unit) {
  if (!values.is_array()) return "–";
  std::string out;
  for (const auto& value : values) out += (out.empty() ? "" : " × ") + number_text(value, places);
  return out + " " + unit;
}

std::string vents_table(const ReportJson& vents) {
  if (!vents.is_array()) return "";
  if (vents.empty()) return "<p>No holes need to be drilled: no air is shut in.</p>\n";
  html::Rows rows;
  for (std::size_t i = 0; i < vents.size(); ++i) {
    const ReportJson& place = at(vents[i], {"place_mm"});
    if (place.size() != 3) continue;
    rows.push_back({std::to_string(i + 1), number_text(place[0], 1), number_text(place[1], 1),
                    number_text(place[2], 1), number_text(at(vents[i], {"diameter_mm"}), 1)});
  }
  return html::table("Holes to drill into the mold, so that no air stays under the sheet",
                     {{"Vent"}, {"x, mm", true}, {"y, mm", true}, {"z, mm", true}, {"Diameter, mm", true}},
                     rows);
}

// One row for each setting: name, value, default, unit and meaning; those that differ from the default come first.
std::string settings_table(const ReportJson& settings) {
  const ReportJson defaults = to_json(Settings{}), schema = settings_schema();
  html::Rows differ, same;
  for (const auto& [group, fields] : settings.items()) {
    html::Rows* last = nullptr;
    for (const auto& [key, value] : fields.items()) {
      const ReportJson& usual = at(defaults, {group.c_str(), key.c_str()});
      const ReportJson& about = at(schema, {"properties", group.c_str(), "properties", key.c_str()});
      const ReportJson& unit = at(about, {"x-unit"});
      html::Rows& rows = value == usual ? same : differ;
      if (&rows == &same && last != &same) same.push_back({group}), last = &same;
      rows.push_back({group + "." + key, text_of(value), text_of(usual),
                      unit.is_string() && unit != "1" ? unit.get<std::string>() : "",
                      text_of(at(about, {"description"}))});
    }
  }
  const std::vector<html::Column> columns{{"Setting"}, {"Value"}, {"Default"}, {"Unit"}, {"What it is"}};
  return (differ.empty() ? std::string("<p>All settings were left at their defaults.</p>\n")
                         : html::table("Settings that differ from the defaults", columns, differ)) +
         html::table("All other settings, at their defaults", columns, same);
}

}  // namespace

std::string process_section(const ReportJson& report) {
  Facts heat, forming;
  const auto fact = [](Facts& facts, const std::string& name, const std::string& value) {
    if (value != "–") facts.emplace_back(name, value);
  };
  fact(heat, "Source", text_of(at(report, {"heat", "source"})));
  fact(heat, "Coldest, mean, hottest place in the frame's window",
       number_text(at(report, {"heat", "least_c"}), 1) + ", " +
           number_text(at(report, {"heat", "mean_c"}), 1) + ", " +
           number_text(at(report, {"heat", "most_c"}), 1) + " °C");
  fact(heat, "Time under the heaters", number_text(at(report, {"heat", "seconds"}), 0, "s"));
  fact(heat, "Between the faces of the sheet",
       number_text(at(report, {"heat", "through_thickness_c"}), 1, "°C"));
  const ReportJson& f = at(report, {"forming"});
  const ReportJson& converged = at(f, {"converged"});
  fact(forming, "Came to rest", converged.is_boolean() ? (converged.get<bool>() ? "yes" : "no") : "–");
  fact(forming, "Largest force imbalance, of the pressure on a node", text_of(at(f, {"residual"})));
  fact(forming, "Largest gap where the sheet touches the mold",
       number_text(at(f, {"gap_mm", "max"}), 3, "mm"));
  fact(forming, "Largest penetration of the mold through the sheet",
       number_text(at(f, {"penetration_mm", "max"}), 3, "mm"));
  fact(forming, "Change of the plastic's volume", text_of(at(f, {"mass_error"})));
  fact(forming, "Support force against pressure force", text_of(at(f, {"force_error"})));
  fact(forming, "Pressure reached", number_text(at(f, {"pressure_kpa"}), 1, "kPa"));
  fact(forming, "Steps of the drape, of the vacuum; iterations",
       text_of(at(f, {"drape_steps"})) + ", " + text_of(at(f, {"vacuum_steps"})) + "; " +
           text_of(at(f, {"iterations"})));
  fact(forming, "Vertices, triangles", text_of(at(f, {"vertices"})) + ", " + text_of(at(f, {"triangles"})));
  fact(forming, "Triangles compressed or folded", text_of(at(f, {"wrinkled_triangles"})));
  fact(forming, "Flipped triangles of the chart", text_of(at(report, {"flattening", "flipped"})));
  fact(forming, "Mold", sizes(at(report, {"mold", "size_mm"}), 1, "mm"));
  fact(forming, "Undercuts", text_of(at(report, {"mold", "undercut_count"})));
  return "<h2>Vents</h2>\n" + vents_table(at(report, {"vents"})) + "<h2>Heat and forming</h2>\n" +
         html::facts("Temperature of the sheet when it met the mold", heat) +
         html::facts("Figures of the simulation", forming);
}

std::string sensitivity_section(const ReportJson& report) {
  const ReportJson& changes = at(report, {"sensitivity", "changes"});
  if (!changes.is_array()) return "";
  html::Rows rows;
  for (const auto& change : changes)
    rows.push_back({text_of(at(change, {"text"})), number_text(at(change, {"mean_mm"}), 2),
                    number_text(at(change, {"max_mm"}), 2)});
  return "<h2>What the print depends on</h2>\n" +
         html::table("Shift of the coils' centres when one thing differs from the settings",
                     {{"If"}, {"Mean, mm", true}, {"Worst coil, mm", true}}, rows);
}

std::string repeat_section(const ReportJson& report) {
  Facts facts{{"Vacuform", text_of(at(report, {"vacuform"}))},
              {"Label on the print", text_of(at(report, {"label"}))}};
  if (const ReportJson& reference = at(report, {"reference"}); reference.is_string())
    facts.emplace_back("Reference", text_of(reference));
  if (at(report, {"sha256"}).is_object())
    for (const auto& [input, digest] : at(report, {"sha256"}).items())
      facts.emplace_back("SHA-256 of the " + input, text_of(digest));
  html::Rows files;
  if (at(report, {"artifacts"}).is_array())
    for (const auto& file : at(report, {"artifacts"}))
      files.push_back({text_of(at(file, {"name"})), text_of(at(file, {"title"}))});
  return "<h2>To repeat this job</h2>\n<p>The same inputs, settings and version give the same bytes.</p>\n" +
         html::facts("Version and inputs", facts) +
         (at(report, {"settings"}).is_object() ? settings_table(at(report, {"settings"})) : "") +
         html::table("Files of this job", {{"File"}, {"What"}}, files);
}

}  // namespace vacuform
