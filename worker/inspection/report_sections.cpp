#include "worker/inspection/report_sections.hpp"

#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/html.hpp"

namespace vacuform {

namespace {

std::string pair_text(const std::string& mean, const std::string& worst) {
  return mean == no_figure ? no_figure : mean + " (" + worst + ")";
}

// "(x, y, z)" in mm.
std::string place_text(const ReportJson& place) {
  if (!place.is_array()) return no_figure;
  std::string out;
  for (const auto& value : place) out += (out.empty() ? "(" : ", ") + number_text(value, 1);
  return out + ")";
}

std::vector<double> numbers(const ReportJson& list) {
  std::vector<double> out;
  for (const auto& value : list) out.push_back(value.is_number() ? value.get<double>() : 0);
  return out;
}

}  // namespace

const ReportJson& at(const ReportJson& json, std::initializer_list<const char*> path) {
  static const ReportJson nothing;
  const ReportJson* here = &json;
  for (const char* key : path) {
    if (!here->is_object()) return nothing;
    const auto found = here->find(key);
    if (found == here->end()) return nothing;
    here = &*found;
  }
  return *here;
}

std::string number_text(const ReportJson& value, int places, const std::string& unit, double factor) {
  if (!value.is_number()) return no_figure;
  return decimal(factor * value.get<double>(), places) + (unit.empty() ? "" : " " + unit);
}
std::string percent_text(const ReportJson& value, int places) { return number_text(value, places, "%", 100); }
std::string signed_percent_text(const ReportJson& value, int places) {
  const std::string text = percent_text(value, places);
  return value.is_number() && value.get<double>() > 0 ? "+" + text : text;
}
std::string text_of(const ReportJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_null()) return no_figure;
  if (value.is_number_float()) return short_decimal(value.get<double>(), 6);
  return value.dump();
}

namespace {

struct CoilsInBoth {
  ReportJson coils = ReportJson::array();  // on the head both as drawn and pre-distorted
  std::size_t count = 0;
  bool all = true;  // no other coil is on the head with either
};
CoilsInBoth coils_in_both(const ReportJson& coils) {
  CoilsInBoth out;
  if (!coils.is_array()) return out;
  for (const ReportJson& coil : coils) {
    const bool drawn = at(coil, {"without", "on_head"}) == true, made = at(coil, {"with", "on_head"}) == true;
    if (drawn && made) out.coils.push_back(coil);
    out.all = out.all && drawn == made;
  }
  out.count = out.coils.size();
  return out;
}

// The mean size of a figure over the coils that have it with both prints; null if none has.
ReportJson mean_over(const ReportJson& coils, const char* way, const char* key) {
  double sum = 0;
  int count = 0;
  for (const ReportJson& coil : coils)
    if (at(coil, {"with", key}).is_number() && at(coil, {"without", key}).is_number()) {
      sum += std::abs(at(coil, {way, key}).get<double>());
      ++count;
    }
  return count > 0 ? ReportJson(sum / count) : ReportJson();
}

}  // namespace

std::vector<std::array<std::string, 3>> key_figures(const ReportJson& report) {
  std::vector<std::array<std::string, 3>> rows;
  const ReportJson &without = at(report, {"figures", "without"}), &with = at(report, {"figures", "with"});
  const auto both = [&](const std::string& title, auto&& text) {
    const std::string a = text(without), b = text(with);
    if (a != no_figure || b != no_figure) rows.push_back({title, a, b});
  };
  const auto percents = [](const char* mean, const char* worst) {
    return [=](const ReportJson& way) {
      return pair_text(percent_text(at(way, {"coils", mean})), percent_text(at(way, {"coils", worst})));
    };
  };
  const ReportJson& coils = at(report, {"coils"});
  const std::string all = " of " + std::to_string(coils.is_array() ? coils.size() : 0);
  both("Coils wholly on the head", [&](const ReportJson& way) {
    if (!coils.is_array() || coils.empty()) return no_figure;
    const std::string on_head = number_text(at(way, {"coils", "on_head"}), 0);
    return (on_head == no_figure ? "0" : on_head) + all;
  });
  both("Circles out of round, mean (worst)", percents("mean_circularity", "worst_circularity"));
  both("Coils off their drawn shape, mean (worst)", percents("mean_shape_error", "worst_shape_error"));
  both("Coil diameters off, mean (worst)", percents("mean_diameter_error", "worst_diameter_error"));
  both("Areas inside coils off, mean (worst)", percents("mean_area_error", "worst_area_error"));
  both("Distances of neighbouring coils off, RMS (worst)", [](const ReportJson& way) {
    return pair_text(number_text(at(way, {"coils", "spacing_rms_mm"}), 2, "mm"),
                     number_text(at(way, {"coils", "worst_spacing_mm"}), 2, "mm"));
  });
  both("Largest coupling |k| of neighbouring coils", [](const ReportJson& way) {
    return number_text(at(way, {"coils", "worst_k"}), 3);
  });
  both("Largest coupling |k| of any two coils", [](const ReportJson& way) {
    const ReportJson& k = at(way, {"coils", "strongest_pair", "k"});
    return k.is_number() ? decimal(std::abs(k.get<double>()), 3) : no_figure;
  });
  // The means above are of the coils on the head with each print. Where these differ, the same coils are compared too.
  if (const CoilsInBoth same = coils_in_both(coils); same.count > 0 && !same.all) {
    const std::string which = std::to_string(same.count) + " of the coils, on the head with both prints: ";
    for (const auto& [key, title] : {std::pair{"circularity", "circles out of round, mean"},
                                     std::pair{"area_error", "areas inside coils off, mean"}})
      rows.push_back({which + title, percent_text(mean_over(same.coils, "without", key)),
                      percent_text(mean_over(same.coils, "with", key))});
  }
  for (const auto& [key, title] :
       {std::pair{"shape", "Shape: longer one way than the other, mean (95 % below)"},
        std::pair{"area", "Area: larger or smaller, mean (95 % below)"}})
    for (const auto& [part, where] :
         {std::pair{"elements", "Around the coils"}, std::pair{"", "The whole chart"},
          std::pair{"favoured", "The region with more weight"}, std::pair{"rest", "Its rest"}})
      both(std::string(where) + ". " + title, [name = key, region = part](const ReportJson& way) {
        const ReportJson& of = *region == 0 ? at(way, {name}) : at(way, {region, name});
        return pair_text(number_text(at(of, {"mean"}), 3, "×"), number_text(at(of, {"p95"}), 3, "×"));
      });
  return rows;
}

std::string key_figures_section(const ReportJson& report) {
  html::Rows rows;
  for (const auto& row : key_figures(report)) rows.emplace_back(row.begin(), row.end());
  std::vector<std::pair<std::string, std::string>> facts;
  const auto fact = [&](const char* title, const std::string& text) {
    if (text != no_figure) facts.emplace_back(title, text);
  };
  fact("Ink of the drawing that is printed", percent_text(at(report, {"pattern", "ink_printed"}), 1));
  fact("Ink of the drawing that lies on the head", percent_text(at(report, {"pattern", "ink_on_head"}), 1));
  fact("Coloured surface of the scan that the sheet does not show",
       percent_text(at(report, {"pattern", "colours", "hidden_share"}), 1));
  if (const ReportJson& hidden = at(report, {"pattern", "colours", "hidden"}); hidden.is_array())
    for (const ReportJson& area : hidden)
      fact("Hidden area",
           number_text(at(area, {"mm2"}), 0, "mm²") + " at " + place_text(at(area, {"place_mm"})));
  fact("Longest stretch along a printed line",
       signed_percent_text(at(report, {"ink", "worst_stretch"}).is_number()
                               ? ReportJson(at(report, {"ink", "worst_stretch"}).get<double>() - 1)
                               : ReportJson(),
                           0));
  fact("Thinnest wall of the whole sheet", number_text(at(report, {"thickness", "least_mm"}), 2, "mm"));
  fact("Thinnest wall under the drawing's region",
       percent_text(at(report, {"thickness", "chart_least_ratio"}), 0) + " of the flat sheet");
  return "<h2>Key figures</h2>\n" +
         html::table("Measured on the formed surface that carries the ink; 0 % and 1 × are perfect",
                     {{"Figure"}, {"Printed as drawn", true}, {"Printed with Vacuform", true}}, rows) +
         html::facts("Ink and wall", facts);
}

std::string colours_section(const ReportJson& report) {
  const ReportJson& errors = at(report, {"pattern", "colours", "errors"});
  if (!errors.is_object()) return "";
  html::Rows rows;
  const auto row = [&](const std::string& title, const ReportJson& part) {
    const ReportJson &position = at(part, {"position_mm"}), &along = at(part, {"along_mm"}),
                     &colour = at(part, {"ciede2000"});
    rows.push_back({title, number_text(at(position, {"mean"}), 2), number_text(at(position, {"p99"}), 2),
                    number_text(at(position, {"max"}), 2), place_text(at(position, {"place_mm"})),
                    number_text(at(along, {"mean"}), 2), number_text(at(along, {"p99"}), 2),
                    number_text(at(colour, {"mean"}), 2), number_text(at(colour, {"p95"}), 2),
                    number_text(at(colour, {"max"}), 1), place_text(at(colour, {"place_mm"}))});
  };
  row("Where the sheet touches the scan", at(errors, {"touching"}));
  row("Everywhere", at(errors, {"whole"}));
  for (const ReportJson& off : at(errors, {"off_register"}))
    row("Touching, print " + text_of(at(off, {"shift_mm"})) + " mm off its marks", off);
  return html::table(
      "The colours on the formed part against those of the scan. Position: from the place on the scan "
      "that a pixel of the print was taken from to the place where it comes to lie. Along: the same on "
      "the scan, without the gap to the sheet. Colour: CIEDE2000, about 1 is the least that people see",
      {{"Part"},
       {"Position, mean, mm", true},
       {"99 % below", true},
       {"Largest", true},
       {"Place, mm", true},
       {"Along, mean, mm", true},
       {"99 % below", true},
       {"Colour, mean", true},
       {"95 % below", true},
       {"Largest", true},
       {"Place, mm", true}},
      rows);
}

std::string warnings_section(const ReportJson& report) {
  const ReportJson& warnings = at(report, {"warnings"});
  if (!warnings.is_array()) return "";
  if (warnings.empty()) return "<h2>Warnings</h2>\n<p>None.</p>\n";
  std::string out = "<h2>Warnings</h2>\n<ul class=\"warnings\">\n";
  for (const auto& warning : warnings) {
    const std::string severity = text_of(at(warning, {"severity"}));
    out += "<li class=\"" + escaped(severity) + "\"><b>" + escaped(severity) + "</b> " +
           escaped(text_of(at(warning, {"what"}))) +
           "<br><span class=\"soft\">Where: " + escaped(text_of(at(warning, {"place"}))) +
           ".</span> <b>Fix:</b> " + escaped(text_of(at(warning, {"fix"}))) + " <code class=\"soft\">" +
           escaped(text_of(at(warning, {"code"}))) + "</code>";
    const ReportJson& marks = at(warning, {"marks"});
    if (marks.is_array() && !marks.empty()) {
      out += "<br><span class=\"soft\">Places (x, y, z) in mm on the part, and how large:";
      for (std::size_t i = 0; i < marks.size(); ++i)
        out += std::string(i == 0 ? " " : "; ") + std::to_string(i + 1) + ". " +
               escaped(place_text(at(marks[i], {"place_mm"}))) + " " +
               escaped(number_text(at(marks[i], {"size_mm"}), 1));
      out += "</span>";
    }
    out += "</li>\n";
  }
  return out + "</ul>\n";
}

std::string segments_section(const ReportJson& report) {
  const ReportJson &all = at(report, {"segments"}), &segments = at(all, {"segments"}),
                   &seams = at(all, {"seams"});
  if (!segments.is_array()) return "";
  html::Rows rows;
  for (const auto& segment : segments)
    rows.push_back({std::to_string(rows.size() + 1), number_text(at(segment, {"distortion"}), 3, "×"),
                    number_text(at(segment, {"area_mm2"}), 0)});
  std::string out =
      html::table("Segments, each placed on its own. Distortion: the bound that 95 % of the area stays below",
                  {{"Segment"}, {"Distortion", true}, {"Area, mm²", true}}, rows);
  rows.clear();
  for (const auto& seam : seams)
    rows.push_back({text_of(seam["segments"][0]) + " – " + text_of(seam["segments"][1]),
                    number_text(at(seam, {"length_mm"}), 1), number_text(at(seam, {"mean_jump_mm"}), 2),
                    number_text(at(seam, {"max_jump_mm"}), 2), number_text(at(seam, {"gap_mm"}), 3),
                    place_text(at(seam, {"place_mm"}))});
  if (!rows.empty())
    out += html::table(
        "Seams: how far the drawing jumps from one side to the other, and how far the sides lie apart "
        "on the print",
        {{"Between"},
         {"Length, mm", true},
         {"Jump, mean, mm", true},
         {"Jump, worst, mm", true},
         {"Apart on the print, mm", true},
         {"Place, mm", true}},
        rows);
  return out;
}

std::string traces_section(const ReportJson& report) {
  const ReportJson& ink = at(report, {"ink"});
  if (!ink.is_object()) return "";
  std::string out = "<h2>Traces and ink</h2>\n";
  const std::string limit = percent_text(at(ink, {"stretch_limit"}), 0);
  const ReportJson& stretched = at(ink, {"stretched"});
  if (!stretched.is_array() || stretched.empty())
    return out + "<p>No printed line is stretched by more than " + escaped(limit) +
           ", the limit of the ink.</p>\n";
  html::Rows rows;
  for (const auto& trace : stretched) {
    const std::string id = text_of(at(trace, {"id"}));
    rows.push_back({id.empty() ? "between elements" : id, number_text(at(trace, {"worst_stretch"}), 2, "×"),
                    place_text(at(trace, {"worst_place_mm"})), number_text(at(trace, {"stretched_mm"}), 0),
                    number_text(at(trace, {"length_mm"}), 0)});
  }
  return out + html::table(
                   "Traces stretched by more than " + limit + ", which coils.stretch_limit sets for the ink",
                   {{"Trace"},
                    {"Worst stretch", true},
                    {"There, mm", true},
                    {"Length beyond the limit, mm", true},
                    {"Length, mm", true}},
                   rows);
}

std::string histograms_section(const ReportJson& report) {
  const ReportJson& all = at(report, {"histograms"});
  if (!all.is_object()) return "";
  std::string out = "<h2>Distributions</h2>\n" + html::legend() + "<div class=\"charts\">";
  for (const auto& [key, title, quantity] :
       {std::tuple{"shape", "Shape distortion over the chart",
                   "shape distortion (1: a circle stays a circle)"},
        std::tuple{"area", "Area distortion over the chart", "area distortion (1: true to scale)"},
        std::tuple{"thickness_ratio", "Wall after forming", "thickness, of the flat sheet"}}) {
    const ReportJson& h = at(all, {key});
    const bool one = at(h, {"shares"}).is_array();
    if (!h.is_object()) continue;
    out += html::histogram({title, quantity, at(h, {"low"}).get<double>(), at(h, {"step"}).get<double>(),
                            numbers(at(h, {one ? "shares" : "with"})),
                            one ? std::vector<double>{} : numbers(at(h, {"without"})), true});
  }
  return out + "</div>\n";
}

std::string found_text(const ReportJson& report, const std::string& after) {
  const ReportJson& found = at(report, {"pattern", "found"});
  if (!found.is_object()) return {};
  return found_caption(at(found, {"coils"}).get<int>(), at(found, {"figures"}).get<int>(),
                       at(found, {"loose_ink_mm2"}).get<double>()) +
         after;
}

}  // namespace vacuform
