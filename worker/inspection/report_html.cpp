#include "worker/inspection/report_html.hpp"

#include <cmath>
#include <map>

#include "api/base/decimal.hpp"
#include "worker/inspection/caption.hpp"
#include "worker/inspection/html.hpp"
#include "worker/inspection/report_sections.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr int picture_width = 620;

// The previews as an <img> can hold them, by their names.
using Embedded = std::map<std::string, std::string>;
Embedded embedded_previews(const std::vector<Artifact>& files) {
  std::vector<const Artifact*> previews;
  for (const Artifact& file : files)
    if (file.name.starts_with("preview-")) previews.push_back(&file);
  std::vector<std::string> data(previews.size());
  each_in_parallel(0, static_cast<int>(data.size()), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    data[at] = embedded_png(previews[at]->bytes, picture_width, caption_top);
  });
  Embedded out;
  for (std::size_t i = 0; i < data.size(); ++i) out.emplace(previews[i]->name, std::move(data[i]));
  return out;
}

// A preview with its title as the caption; the title inside the picture was cut off.
std::string picture(const Embedded& previews, const std::string& name) {
  const auto found = previews.find(name);
  const ArtifactKind* kind = artifact_kind(name);
  if (found == previews.end() || !kind || found->second.empty()) return "";
  const std::string title = escaped(kind->title);
  return "<figure><img alt=\"" + title + "\" src=\"data:image/png;base64," + found->second +
         "\"><figcaption>" + title + "</figcaption></figure>\n";
}

std::string pictures(const std::string& heading, const Embedded& previews,
                     std::initializer_list<const char*> names) {
  std::string out;
  for (const char* name : names) out += picture(previews, name);
  return out.empty() ? "" : "<h2>" + heading + "</h2>\n<div class=\"pictures\">\n" + out + "</div>\n";
}

std::string numbers(const ReportJson& values, int places, const char* between) {
  std::string out;
  if (values.is_array())
    for (const auto& value : values) out += (out.empty() ? "" : between) + number_text(value, places);
  return out.empty() ? "–" : out;
}

// What was asked and what was done, in a few sentences.
std::string summary(const ReportJson& r) {
  const ReportJson& s = at(r, {"settings"});
  const ReportJson& offset = at(s, {"pattern", "offset_mm"});
  std::string material = text_of(at(s, {"sheet", "material"}));
  for (char& c : material)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  const ReportJson& coils = at(r, {"coils"});
  const bool of_scan = text_of(at(s, {"pattern", "source"})) == "scan";
  std::string text = "The colours of the scan";
  if (!of_scan) {
    text = "A drawing of " + numbers(at(r, {"pattern", "size_mm"}), 1, " × ") + " mm (" +
           text_of(at(r, {"pattern", "format"}));
    if (const ReportJson& from = at(r, {"pattern", "size_from"}); from.is_string() && from != "")
      text += ", from " + text_of(from);
    if (coils.is_array() && !coils.empty()) text += ", " + std::to_string(coils.size()) + " coils";
    text += ")";
  }
  text += " for a sheet of " + material + ", " + number_text(at(s, {"sheet", "width_mm"}), 0) + " × " +
          number_text(at(s, {"sheet", "height_mm"}), 0) + " × " + text_of(at(s, {"sheet", "thickness_mm"})) +
          " mm, formed over a mold of " + numbers(at(r, {"mold", "size_mm"}), 0, " × ") + " mm at " +
          number_text(at(r, {"heat", "mean_c"}), 0, "°C") + ". The print is for the " +
          text_of(at(r, {"print", "inked_face"})) + " face";
  text += at(r, {"print", "mirrored"}) == true ? " and mirrored." : ".";
  if (!of_scan) {
    const std::string from_top = numbers(offset, 1, ", ");
    text += " The drawing's centre lies ";
    if (from_top != "0.0, 0.0") text.append("(").append(from_top).append(") mm from ");
    text += from_top == "0.0, 0.0" ? "on the top of the mold" : "the top of the mold";
    text += ", turned by " + text_of(at(s, {"pattern", "rotate_deg"})) + " degrees, at " +
            text_of(at(s, {"pattern", "scale"})) + " times its size.";
    if (const std::string found = found_text(r, ""); !found.empty()) text += " " + found;
  }
  const std::string left = text_of(at(r, {"scan", "left_side"}));
  if (left == "minus_x" || left == "plus_x")
    text += std::string(" The patient's left is at ") + (left == "minus_x" ? "-x" : "+x") +
            ", confirmed by a person.";
  return "<p>" + escaped(text) + "</p>\n";
}

std::string lengths_part(const ReportJson& report) {
  const ReportJson& lengths = at(report, {"pattern", "lengths"});
  if (!lengths.is_object()) return "";
  const auto percent = [&](const char* key) {
    return in_percent(std::abs(at(lengths, {key}).get<double>()), 1);
  };
  return "<p>Lines of the drawing come out longer or shorter than drawn by " + percent("mean_error") +
         " on average; 95 % of their length by less than " + percent("p95_error") + ". The worst place, " +
         percent("worst_error") + (at(lengths, {"worst_error"}) < 0 ? " shorter" : " longer") + ", is at " +
         numbers(at(lengths, {"worst_place_mm"}), 1, ", ") + " mm.</p>\n";
}

std::string reading() {
  return "<h2>How to read this</h2>\n<ul>\n"
         "<li>Everything is measured on the simulated part, on the face of the sheet that carries the ink. "
         "No formed part "
         "was measured.</li>\n"
         "<li><b>Printed as drawn</b> is the plain drawing on the flat sheet, its centre where the top of "
         "the mold comes "
         "to lie. <b>Printed with Vacuform</b> is this job's print.</li>\n"
         "<li><b>Diameter</b>: twice the mean distance of a coil from its centre along the surface. <b>Out "
         "of round</b>: "
         "the largest departure from that mean, as a share of it, for loops that are drawn as circles. The "
         "centre is "
         "the point from which the distances vary least.</li>\n"
         "<li><b>Off its shape</b>: the largest distance between a loop and its own drawn shape, whatever "
         "that is, after "
         "the rotation and shift that fit best, in mm and as a share of its diameter.</li>\n"
         "<li><b>Coupling k</b>: mutual inductance over the geometric mean of the self inductances, of the "
         "lines in "
         "space. Neighbours that do not couple have 0.</li>\n"
         "<li><b>Shape distortion</b>: how much longer a small circle of the drawing comes out one way than "
         "the "
         "other. <b>Area "
         "distortion</b>: how much larger or smaller it comes out, always given above 1.</li>\n"
         "<li>Places are in mm: z is the height above the platform, x and y are from the sheet's centre, as "
         "on the "
         "print.</li>\n</ul>\n";
}

}  // namespace

std::string report_html(const ReportJson& report, const std::vector<Artifact>& files) {
  const Embedded previews = embedded_previews(files);
  const ReportJson& reference = at(report, {"reference"});
  const std::string label = escaped(text_of(at(report, {"label"})) +
                                    (reference.is_string() ? ", reference " + text_of(reference) : ""));
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Vacuform report " +
      label + "</title>\n<style>";
  out += html::style();
  out += "</style>\n</head>\n<body>\n<header>\n<h1>Vacuform report " + label + "</h1>\n" + summary(report) +
         "</header>\n<main>\n";
  out += key_figures_section(report);
  out += pictures("Drawing, print and part", previews,
                  {"preview-pattern.png", "preview-print.png", "preview-without.png", "preview-with.png"});
  out += pictures("The print on the head", previews, {"preview-views.png"});
  out += pictures("Lengths", previews, {"preview-lengths.png"});
  out += lengths_part(report);
  out +=
      pictures("The colours of the scan", previews,
               {"preview-original.png", "preview-position.png", "preview-colour.png", "preview-align.png"});
  out += colours_section(report);
  out += warnings_section(report);
  out += pictures("Segments", previews, {"preview-segments.png"});
  out += segments_section(report);
  out += coils_section(report);
  out += circuits_section(report);
  out += traces_section(report);
  out += pictures("On the part", previews,
                  {"preview-findings.png", "preview-thickness.png", "preview-shape.png", "preview-area.png",
                   "preview-gap.png", "preview-temperature.png"});
  out += histograms_section(report);
  out += process_section(report);
  out += sensitivity_section(report);
  out += reading();
  out += repeat_section(report);
  out += "</main>\n<footer class=\"soft\"><p>Not a medical device.</p></footer>\n</body>\n</html>\n";
  return out;
}

}  // namespace vacuform
