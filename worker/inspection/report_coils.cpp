// The part of report.html about the coils: their table, their neighbours, and how every two of them couple.
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/inspection/html.hpp"
#include "worker/inspection/report_sections.hpp"

namespace vacuform {

namespace {

std::string coil_cell(const ReportJson& coil, const char* way, const char* key, int places, bool percent) {
  const ReportJson& value = at(coil, {way, key});
  return percent ? signed_percent_text(value, places) : number_text(value, places);
}

html::Rows coil_rows(const ReportJson& coils) {
  html::Rows rows;
  for (const auto& coil : coils) {
    const ReportJson& on_head = at(coil, {"with", "on_head"});
    rows.push_back(
        {text_of(at(coil, {"id"})),
         on_head.is_boolean() ? (on_head.get<bool>() ? "yes" : "in part") : "not whole",
         number_text(at(coil, {"drawn_diameter_mm"}), 2), coil_cell(coil, "with", "diameter_mm", 2, false),
         coil_cell(coil, "without", "diameter_error", 1, true),
         coil_cell(coil, "with", "diameter_error", 2, true),
         percent_text(at(coil, {"without", "circularity"}), 1),
         percent_text(at(coil, {"with", "circularity"})),
         number_text(at(coil, {"with", "shape_largest_mm"}), 2),
         percent_text(at(coil, {"with", "shape_error"})), coil_cell(coil, "without", "area_error", 1, true),
         coil_cell(coil, "with", "area_error", 2, true), number_text(at(coil, {"with", "worst_stretch"}), 2),
         number_text(at(coil, {"with", "inductance_nh"}), 1)});
  }
  return rows;
}

html::Rows pair_rows(const ReportJson& pairs) {
  html::Rows rows;
  for (const auto& pair : pairs)
    rows.push_back({text_of(pair["coils"][0]) + " – " + text_of(pair["coils"][1]),
                    number_text(at(pair, {"drawn_distance_mm"}), 2),
                    number_text(at(pair, {"without", "distance_mm"}), 2),
                    number_text(at(pair, {"with", "distance_mm"}), 2),
                    number_text(at(pair, {"drawn_overlap_mm"}), 2),
                    number_text(at(pair, {"with", "overlap_mm"}), 2),
                    number_text(at(pair, {"without", "k"}), 3), number_text(at(pair, {"with", "k"}), 4)});
  return rows;
}

std::optional<double> percent_of(const ReportJson& value) {
  return value.is_number() ? std::optional(100 * value.get<double>()) : std::nullopt;
}
std::string bars_of(const ReportJson& coils, const char* key, const std::string& title, bool signed_values) {
  html::Bars bars{title, "per cent", signed_values, {}};
  for (const auto& coil : coils)
    bars.rows.push_back({text_of(at(coil, {"id"})), percent_of(at(coil, {"with", key})),
                         percent_of(at(coil, {"without", key}))});
  return html::bars(bars);
}

// "coil-1 and coil-2, k = -0.0190 at 57.40 mm"
std::string coupled_text(const ReportJson& pair) {
  const ReportJson& coils = at(pair, {"coils"});
  if (!coils.is_array() || coils.size() != 2) return no_figure;
  return text_of(coils[0]) + " and " + text_of(coils[1]) + ", k = " + number_text(at(pair, {"k"}), 4) +
         " at " + number_text(at(pair, {"distance_mm"}), 2, "mm");
}

// The pairs of the matrix, strongest first.
html::Rows strongest_rows(const ReportJson& couplings, std::size_t most) {
  struct Pair {
    std::size_t a, b;
    double k;
  };
  const ReportJson &ids = couplings["coils"], &k = couplings["k"];
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < ids.size(); ++a)
    for (std::size_t b = a + 1; b < ids.size(); ++b)
      if (k[a][b].is_number()) pairs.push_back({a, b, k[a][b].get<double>()});
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& p, const Pair& q) { return std::abs(p.k) > std::abs(q.k); });
  html::Rows rows;
  for (std::size_t i = 0; i < std::min(most, pairs.size()); ++i)
    rows.push_back({text_of(ids[pairs[i].a]) + " – " + text_of(ids[pairs[i].b]), decimal(pairs[i].k, 4)});
  return rows;
}

std::string matrix_table(const ReportJson& couplings) {
  const ReportJson &ids = couplings["coils"], &k = couplings["k"];
  std::vector<html::Column> columns{{"Coil"}};
  html::Rows rows;
  for (std::size_t a = 0; a < ids.size(); ++a) {
    columns.push_back({text_of(ids[a]), true});
    std::vector<std::string> row{text_of(ids[a])};
    for (std::size_t b = 0; b < ids.size(); ++b)
      row.push_back(a == b ? "" : number_text(k[a][b], 1, "", 1000));
    rows.push_back(std::move(row));
  }
  return html::table("Coupling of every two coils on the head, in thousandths of k", columns, rows);
}

std::string couplings_part(const ReportJson& report) {
  const ReportJson& couplings = at(report, {"couplings"});
  std::string out;
  for (const std::string& sentence : {coupling_text(report), what_geometry_allows(report)})
    if (!sentence.empty()) out += "<p>" + escaped(sentence) + "</p>\n";
  if (!at(couplings, {"k"}).is_array()) return out;
  constexpr std::size_t most_columns = 24, most_rows = 10;
  if (couplings["coils"].size() <= most_columns) return out + matrix_table(couplings);
  return out + html::table("The strongest couplings of any two coils on the head; all are in report.json",
                           {{"Coils"}, {"k", true}}, strongest_rows(couplings, most_rows));
}

// What coils.keep kept.
std::string keep_text(const ReportJson& report) {
  const ReportJson& keep = at(report, {"figures", "with", "coils", "keep"});
  if (keep == "area")
    return "Each coil keeps the area inside it (coils.keep=area). Where the surface is round, its diameter "
           "along the surface is a little larger than drawn.";
  if (keep == "diameter")
    return "Each coil keeps its diameter along the surface (coils.keep=diameter). Where the surface is "
           "round, "
           "the area inside it is a little smaller than drawn.";
  return "";
}

}  // namespace

std::string coupling_text(const ReportJson& report) {
  const ReportJson &coils = at(report, {"figures", "with", "coils"}),
                   &neighbours = at(coils, {"strongest_neighbours"}), &all = at(coils, {"strongest_pair"});
  std::string out;
  if (neighbours.is_object()) out = "Strongest coupling of neighbours: " + coupled_text(neighbours) + ".";
  if (!all.is_object()) return out;
  if (neighbours.is_object() && at(all, {"coils"}) == at(neighbours, {"coils"}))
    return out + " No other two coils couple more.";
  return out + (out.empty() ? "" : " ") + "Strongest of any two coils: " + coupled_text(all) + ".";
}

std::string what_geometry_allows(const ReportJson& report) {
  const ReportJson &coils = at(report, {"figures", "with", "coils"}),
                   &neighbours = at(coils, {"strongest_neighbours"}), &all = at(coils, {"strongest_pair"});
  if (!all.is_object() || (neighbours.is_object() && at(all, {"coils"}) == at(neighbours, {"coils"})))
    return "";
  return "Overlap cancels the coupling of neighbours only. Two circles with another one between them do not "
         "overlap, so they cannot be cancelled at the same time: in a flat hexagon they keep k of about "
         "-0.02, and up to -0.05 where they nearly touch. Low-impedance preamplifiers reduce what is left.";
}

std::string coils_section(const ReportJson& report) {
  const ReportJson &coils = at(report, {"coils"}), &pairs = at(report, {"pairs"});
  if (!coils.is_array() || coils.empty()) return "";
  std::string out = "<h2>Coils</h2>\n" + html::legend() + "<div class=\"charts\">" +
                    bars_of(coils, "shape_error", "Off its drawn shape, of its diameter, by coil", false) +
                    bars_of(coils, "diameter_error", "Diameter off, by coil", true) + "</div>\n" +
                    html::table("Coils, each from its own centre along the surface. Plain: printed as drawn",
                                {{"Coil"},
                                 {"On the head"},
                                 {"Drawn Ø, mm", true},
                                 {"Formed Ø, mm", true},
                                 {"Ø off, plain", true},
                                 {"Ø off", true},
                                 {"Out of round, plain", true},
                                 {"Out of round", true},
                                 {"Off its shape, mm", true},
                                 {"Off its shape", true},
                                 {"Area off, plain", true},
                                 {"Area off", true},
                                 {"Stretch ×", true},
                                 {"L, nH", true}},
                                coil_rows(coils));
  if (const std::string kept = keep_text(report); !kept.empty()) out += "<p>" + escaped(kept) + "</p>\n";
  if (pairs.is_array() && !pairs.empty())
    out += html::table("Neighbours: distances of the centres along the surface, overlap and coupling k",
                       {{"Coils"},
                        {"Drawn, mm", true},
                        {"Formed, plain", true},
                        {"Formed, mm", true},
                        {"Overlap drawn", true},
                        {"Overlap formed", true},
                        {"k, plain", true},
                        {"k", true}},
                       pair_rows(pairs));
  return out + couplings_part(report);
}

}  // namespace vacuform
