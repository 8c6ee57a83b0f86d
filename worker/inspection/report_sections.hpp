// The sections of report.html, each made from the part of report.json that it shows, and empty if that part is missing.
// Internal to worker/inspection.
#pragma once

#include <array>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace vacuform {

using ReportJson = nlohmann::ordered_json;

// found_caption() of a report, and `after` behind it; nothing where the drawing lies on charts.
std::string found_text(const ReportJson& report, const std::string& after);
inline const std::string no_figure = "–";  // in a cell

// The value at a path of keys; null if it is missing.
const ReportJson& at(const ReportJson& json, std::initializer_list<const char*> path);

// A number times `factor` as text, with `places` digits and the unit; an en dash if it is missing.
std::string number_text(const ReportJson& value, int places, const std::string& unit = "", double factor = 1);
std::string percent_text(const ReportJson& value, int places = 2);         // of a ratio
std::string signed_percent_text(const ReportJson& value, int places = 2);  // with its sign
std::string text_of(const ReportJson& value);                              // any value, in a form for people

// Name, value when printed as drawn, value when printed with Vacuform; for people. Leaves out what the report lacks.
std::vector<std::array<std::string, 3>> key_figures(const ReportJson& report);

// One or two sentences about the strongest coupling: between neighbours, and between any two coils, by name with k and
// distance. Empty if nothing couples.
std::string coupling_text(const ReportJson& report);
// "16 loops: 16 nets, 0 shorts, 0 opens; 66 bridges, 64 gaps."; empty without loops.
std::string circuits_text(const ReportJson& report);
// Why the strongest pair stays coupled if it is not a pair of neighbours; otherwise empty.
std::string what_geometry_allows(const ReportJson& report);

std::string key_figures_section(const ReportJson& report);
std::string warnings_section(const ReportJson& report);
std::string colours_section(const ReportJson& report);  // against those of the scan
std::string segments_section(const ReportJson& report);
std::string coils_section(const ReportJson& report);
std::string circuits_section(const ReportJson& report);
std::string traces_section(const ReportJson& report);
std::string histograms_section(const ReportJson& report);
std::string process_section(const ReportJson& report);  // mold, heat, forming, vents
std::string sensitivity_section(const ReportJson& report);
std::string repeat_section(const ReportJson& report);  // settings, versions, digests

}  // namespace vacuform
