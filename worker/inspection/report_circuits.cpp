// The part of report.html about the loops as circuits: what is printed, what they lose, what is soldered.
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/inspection/html.hpp"
#include "worker/inspection/report_sections.hpp"

namespace vacuform {

namespace {

std::string loops_table(const ReportJson& electrical) {
  html::Rows rows;
  for (const ReportJson& loop : electrical["loops"])
    rows.push_back({text_of(loop["id"]), number_text(loop["inductance_nh"], 1),
                    number_text(loop["coil_ohm"], 2), number_text(loop["body_ohm"], 2),
                    number_text(loop["most_body_ohm"], 2), number_text(loop["unloaded_q"], 0),
                    number_text(loop["loaded_q"], 0), number_text(loop["noise_db"], 2),
                    number_text(loop["capacitors"][0]["total_pf"], 1),
                    number_text(loop["capacitors"][1]["total_pf"], 1),
                    number_text(loop["capacitors"][2]["total_pf"], 2)});
  return html::table(
      "Loops at " + number_text(electrical["frequency_mhz"], 2) +
          " MHz. R of the body is that of a sphere, and at most that of a half space. Noise: what the "
          "loss of the coil adds to that of the body",
      {{"Loop"},
       {"L, nH", true},
       {"R of the coil, Ω", true},
       {"R of the body, Ω", true},
       {"at most, Ω", true},
       {"Q unloaded", true},
       {"Q loaded", true},
       {"Noise, dB", true},
       {"C at 1.5 T, pF", true},
       {"at 3 T", true},
       {"at 7 T", true}},
      rows);
}

std::string current_text(const ReportJson& electrical) {
  const ReportJson& strongest = electrical["strongest_current"];
  if (!strongest.is_object()) return "";
  return "<p>A current in " + escaped(text_of(strongest["from"])) + " drives " +
         number_text(strongest["share"], 3) + " of it in " + escaped(text_of(strongest["to"])) +
         ", the most of all pairs; " + number_text(strongest["with_preamplifiers"], 3) +
         " with preamplifiers of " + number_text(electrical["preamp_db"], 0) + " dB.</p>\n";
}

std::string capacitors_table(const ReportJson& electrical) {
  html::Rows rows;
  for (const ReportJson& loop : electrical["loops"])
    for (const ReportJson& gap : loop["gaps"]) {
      const ReportJson& place = gap["place_mm"];
      rows.push_back({number_text(gap["number"], 0), text_of(loop["id"]),
                      gap["port"] == true        ? "port"
                      : gap["plate"].is_object() ? "printed"
                                                 : "capacitor",
                      number_text(gap["wanted_pf"], 2),
                      gap["plate"].is_object() ? number_text(gap["plate"]["pf"], 1) + " ± " +
                                                     number_text(gap["plate"]["pf"].get<double>() *
                                                                     gap["plate"]["tolerance"].get<double>(),
                                                                 1)
                                               : number_text(gap["standard_pf"], 1),
                      number_text(place[0], 1), number_text(place[1], 1), number_text(place[2], 1)});
    }
  if (rows.empty()) return "";
  return html::table(
      "Capacitors to start from: those of a port match it, all others tune the loop; those of a printed one "
      "have the "
      "tolerance of the sheet's thickness. The numbers are printed beside the gaps",
      {{"Number"},
       {"Loop"},
       {"Gap"},
       {"Wanted, pF", true},
       {"E24 or printed, pF", true},
       {"x, mm", true},
       {"y, mm", true},
       {"z, mm", true}},
      rows);
}

std::string tails_table(const ReportJson& circuits) {
  html::Rows rows;
  for (const ReportJson& coil : circuits["coils"]) {
    const ReportJson& tail = coil["tail"];
    if (!tail.is_object()) continue;
    const ReportJson& place = tail["pads_mm"];
    std::string over;
    for (const ReportJson& crossing : tail["crossings"])
      over += (over.empty() ? "" : ", ") + text_of(crossing["under"]);
    rows.push_back({number_text(tail["number"], 0), text_of(coil["id"]), number_text(tail["length_mm"], 0),
                    number_text(tail["ohm"], 2), number_text(tail["inductance_nh"], 0),
                    number_text(tail["reactance_ohm"], 0), number_text(tail["most_stretch"], 2), over,
                    number_text(place[0], 1), number_text(place[1], 1), number_text(place[2], 1)});
  }
  if (rows.empty()) return "";
  return html::table(
      "Tails: two leads from each port to its pads, which have the number of the port. R and L are those of "
      "both leads together, and are in series with the port",
      {{"Number"},
       {"Loop"},
       {"Length, mm", true},
       {"R, Ω", true},
       {"L, nH", true},
       {"ωL, Ω", true},
       {"Stretch", true},
       {"Over"},
       {"x, mm", true},
       {"y, mm", true},
       {"z, mm", true}},
      rows);
}

std::string couplings_picture(const ReportJson& report) {
  const ReportJson &ids = at(report, {"couplings", "coils"}), &k = at(report, {"couplings", "k"});
  if (!k.is_array()) return "";
  html::Matrix matrix{"Coupling k of every two coils, in full colour from 0.03 on", {}, {}, 0.03};
  for (std::size_t a = 0; a < ids.size(); ++a) {
    matrix.names.push_back(text_of(ids[a]));
    auto& row = matrix.values.emplace_back();
    for (std::size_t b = 0; b < ids.size(); ++b)
      row.push_back(a != b && k[a][b].is_number() ? std::optional(k[a][b].get<double>()) : std::nullopt);
  }
  return html::matrix(matrix);
}

}  // namespace

std::string circuits_text(const ReportJson& report) {
  const ReportJson& circuits = at(report, {"circuits"});
  if (!circuits.is_object()) return "";
  const auto counted = [](std::size_t count, const std::string& what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
  };
  std::size_t gaps = 0, reverse = 0, tails = 0, over = 0;
  double widest = 1;
  for (const ReportJson& coil : circuits["coils"]) {
    gaps += coil["gaps"].size();
    if (coil["tail"].is_object()) ++tails, over += coil["tail"]["crossings"].size();
    if (coil["widest"].is_number()) widest = std::max(widest, coil["widest"].get<double>());
    reverse += coil["face"] != circuits["coils"].front()["face"];
  }
  std::string out = counted(circuits["loops"].get<std::size_t>(), "loop") + ": " +
                    counted(circuits["nets"].get<std::size_t>(), "net") + ", " +
                    counted(circuits["shorts"].size(), "short") + ", " +
                    counted(circuits["opens"].size(), "open") + "; " +
                    counted(circuits["bridges"].size(), "bridge") + ", " + counted(gaps, "gap");
  if (reverse > 0) out += "; on two faces";
  if (tails > 0) out += "; " + counted(tails, "tail") + " over " + counted(over, "trace");
  if (widest > 1) out += "; traces up to " + decimal(widest, 1) + " times as wide as drawn";
  return out + ".";
}

std::string circuits_section(const ReportJson& report) {
  const std::string checked = circuits_text(report);
  if (checked.empty()) return "";
  std::string out = "<h2>Circuits</h2>\n<p>" + escaped(checked) + "</p>\n" + couplings_picture(report);
  const ReportJson& electrical = at(report, {"circuits", "electrical"});
  if (!electrical.is_object()) return out;
  if (electrical["order_of_magnitude"] == true)
    out +=
        "<p><strong>The figures of losses, noise and matching are quasi-static. Above 200 MHz they give no "
        "more than the order "
        "of magnitude.</strong></p>\n";
  return out + current_text(electrical) + loops_table(electrical) + capacitors_table(electrical) +
         tails_table(at(report, {"circuits"}));
}

}  // namespace vacuform
