#include "worker/inspection/summary.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/report_sections.hpp"

namespace vacuform {

namespace {

// Signs of other scripts and "×" take more bytes than places.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}
std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string spaces(width - std::min(width, width_of(text)), ' ');
  return right ? spaces + text : text + spaces;
}

std::string table(const std::vector<std::array<std::string, 3>>& rows) {
  std::array<std::size_t, 3> widths{};
  for (const auto& row : rows)
    for (std::size_t k = 0; k < 3; ++k) widths[k] = std::max(widths[k], width_of(row[k]));
  std::string out;
  for (const auto& row : rows)
    out += padded(row[0], widths[0], false) + "  " + padded(row[1], widths[1], true) + "  " +
           padded(row[2], widths[2], true) + "\n";
  return out;
}

int count_of(const ReportJson& report, const char* severity) {
  const ReportJson& warnings = at(report, {"warnings"});
  return static_cast<int>(std::count_if(warnings.begin(), warnings.end(), [&](const ReportJson& w) {
    return at(w, {"severity"}) == severity;
  }));
}

std::string plural(int count, const char* one, const char* several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

std::string warnings_text(const ReportJson& report) {
  const ReportJson& warnings = at(report, {"warnings"});
  if (warnings.empty()) return "No warnings.\n";
  std::string out = plural(count_of(report, "serious"), "serious warning, ", "serious warnings, ") +
                    plural(count_of(report, "warning"), "warning, ", "warnings, ") +
                    plural(count_of(report, "note"), "note\n", "notes\n");
  for (const char* severity : {"serious", "warning", "note"})
    for (const ReportJson& warning : warnings)
      if (at(warning, {"severity"}) == severity)
        out += "  " + std::string(severity) + ": " + text_of(at(warning, {"what"})) + " [" +
               text_of(at(warning, {"code"})) + "]\n    Where: " + text_of(at(warning, {"place"})) +
               "\n    Fix: " + text_of(at(warning, {"fix"})) + "\n";
  return out;
}

ReportJson coils_on_head(const ReportJson& report) {
  const ReportJson& coils = at(report, {"coils"});
  if (!coils.is_array() || coils.empty()) return nullptr;
  const ReportJson& on_head = at(report, {"figures", "with", "coils", "on_head"});
  return on_head.is_number() ? on_head : ReportJson(0);
}

}  // namespace

int serious_warnings(const ReportJson& report) { return count_of(report, "serious"); }

ReportJson summary_json(const ReportJson& report, const std::string& out) {
  ReportJson files = ReportJson::array();
  for (const ReportJson& file : at(report, {"artifacts"})) files.push_back(at(file, {"name"}));
  const ReportJson& coils = at(report, {"coils"});
  return {{"label", at(report, {"label"})},
          {"reference", at(report, {"reference"})},
          {"out", out},
          {"coils", coils.is_array() && !coils.empty() ? ReportJson(coils.size()) : ReportJson()},
          {"coils_on_head", coils_on_head(report)},
          {"ink_printed", at(report, {"pattern", "ink_printed"})},
          {"ink_on_head", at(report, {"pattern", "ink_on_head"})},
          {"figures", at(report, {"figures"})},
          {"warnings", at(report, {"warnings"})},
          {"serious_warnings", serious_warnings(report)},
          {"files", std::move(files)}};
}

std::string summary_text(const ReportJson& report, const std::string& out) {
  const ReportJson& size = at(report, {"pattern", "size_mm"});
  const ReportJson& reference = at(report, {"reference"});
  std::string text = "Print " + text_of(at(report, {"label"})) +
                     (reference.is_string() ? ", reference " + text_of(reference) : "") + ", for the " +
                     text_of(at(report, {"print", "inked_face"})) + " face" +
                     (at(report, {"print", "mirrored"}) == true ? " (mirrored)" : "");
  const ReportJson& faded = at(report, {"pattern", "colours", "faded_share"});
  const bool both = at(report, {"settings", "pattern", "source"}) == "both";
  if (!both && faded.is_number()) {
    text += ", of the colours of the scan.\n" + colours_caption(faded.get<double>()) + "\n\n";
  } else {
    if (size.is_array() && size.size() == 2)
      text += ", of a drawing of " + number_text(size[0], 1) + " × " + number_text(size[1], 1) + " mm";
    if (const ReportJson& from = at(report, {"pattern", "size_from"}); from.is_string() && from != "")
      text += " (from " + text_of(from) + ")";
    text += ".\n" + found_text(report, "\n") + percent_text(at(report, {"pattern", "ink_on_head"}), 1) +
            " of its ink lies on the head";
    if (const ReportJson on_head = coils_on_head(report); on_head.is_number())
      text += ", with " + text_of(on_head) + " of " + std::to_string(at(report, {"coils"}).size()) + " coils";
    text += ".\n";
    if (both && faded.is_number()) text += colours_caption(faded.get<double>()) + "\n";
    text += "\n";
    std::vector<std::array<std::string, 3>> rows{{"", "as drawn", "with Vacuform"}};
    for (auto& row : key_figures(report)) rows.push_back(std::move(row));
    text += table(rows) + "\n";
  }
  if (const std::string circuits = circuits_text(report); !circuits.empty()) text += circuits + "\n";
  if (const std::string coupling = coupling_text(report); !coupling.empty()) {
    text += coupling + "\n";
    if (const std::string why = what_geometry_allows(report); !why.empty()) text += why + "\n";
    text += "\n";
  }
  text += warnings_text(report) + "\n";
  return text + "Files: " + out + " (print.svg, print.pdf and print.png" +
         (both ? ", of the colours colours.svg, colours.pdf and colours.png" : "") +
         "; begin with report.html)\n";
}

}  // namespace vacuform
