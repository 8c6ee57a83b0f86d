#include "server/pages/findings.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"

namespace vacuform {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

std::string size_text(const json& size) {
  if (!size.is_array() || size.size() != 3) return "-";
  return number(size[0], 1) + " x " + number(size[1], 1) + " x " + number(size[2], 1) + " mm";
}

bool is_true(const json& object, const char* key) { return at(object, {key}) == json(true); }

}  // namespace

ordered_json findings_values(const json& findings) {
  const json& scan = at(findings, {"scan"});
  if (!scan.is_object()) return nullptr;
  ordered_json rows = ordered_json::array();
  const auto row = [&](const char* title, const std::string& value) {
    rows.push_back({{"title", title}, {"value", value}});
  };
  const auto count = [&](const char* key) { return number(at(scan, {key}), 0); };
  const auto guessed = [&](const char* key, const char* flag) {
    return text(at(scan, {key})) + (is_true(scan, flag) ? " (guessed)" : "");
  };
  row("Format", text(at(scan, {"format"})) + ", " + count("triangles_read") + " triangles");
  row("Unit",
      is_true(scan, "size_given") ? "none, scaled to the size given" : guessed("unit", "unit_guessed"));
  row("Up", guessed("up", "up_guessed"));
  const std::string space = text(at(scan, {"space"}), "");
  row("Face", guessed("front", "front_assumed") +
                  (!is_true(scan, "front_from_format") ? ""
                   : space.empty()                     ? " (as the format defines)"
                                                       : " (SPACE=" + space + " of the file)") +
                  (is_true(scan, "mirrored") ? ", mirrored" : ""));
  const std::string told = text(at(scan, {"left_from_file"}), "");
  if (!told.empty()) row("Patient's left, as the file says", told + " (SPACE=" + space + ")");
  const std::string left = text(at(scan, {"left_side"}), "");
  if (left == "minus_x" || left == "plus_x")
    row("Patient's left", std::string(left == "minus_x" ? "-x" : "+x") + ", confirmed by a person");
  row("Size, upright", size_text(at(scan, {"size_mm"})));
  row("Pieces", count("components") + ", " + count("components_dropped") + " dropped as debris or inside");
  row("Openings", count("holes_closed") + " closed, " + count("holes_capped") +
                      " walled in down to the platform" +
                      (is_true(scan, "rebuilt") ? ", the skin replaced by a new one" : ""));
  row("Left out", count("outliers_dropped") + " outliers, " + count("crumbs_dropped") +
                      " crumbs that the trim left beside the mold");
  row("Trim above its lowest point", number(at(scan, {"trim_mm"}), 1) + " mm");
  row("Mold", size_text(at(findings, {"mold", "size_mm"})));
  row("Undercuts", number(at(findings, {"mold", "undercut_count"}), 0));
  if (at(findings, {"fits"}).is_boolean()) {  // of an inspection: a print did fit
    const json& misfit = at(findings, {"problem"});
    row("Fits the machine", is_true(findings, "fits")
                                ? "yes"
                                : "no: " + text(at(misfit, {"what"})) + "; " + text(at(misfit, {"fix"})));
  }
  return {{"rows", std::move(rows)}};
}

ordered_json layout_values(const json& layout) {
  if (!at(layout, {"pairs"}).is_number()) return nullptr;
  const auto figure = [&](const char* key, int places) { return number(at(layout, {key}), places); };
  const auto coupling = [&](const char* key) {
    const json& pair = at(layout, {key});
    return text(at(pair, {"a"})) + " and " + text(at(pair, {"b"})) + ", k = " + number(at(pair, {"k"}), 4);
  };
  ordered_json rows = ordered_json::array();
  const auto row = [&](const char* title, const std::string& value) {
    rows.push_back({{"title", title}, {"value", value}});
  };
  row("Coils", figure("count", 0) + ", " + figure("off_head", 0) + " of them not wholly on the head");
  if (const json& share = at(layout, {"covered"}); share.is_number())
    row("Share of the region within a coil", decimal(100 * share.get<double>(), 0) + " %");
  row("Diameter", figure("diameter_mm", 1) + " mm");
  row("Distance of neighbours", figure("spacing_mm", 2) + " mm, " + figure("spacing_rms_mm", 2) +
                                    " mm rms over " + figure("pairs", 0) + " pairs");
  row("Strongest coupling of neighbours", coupling("strongest_neighbours"));
  row("Strongest coupling of any two", coupling("strongest"));
  return {{"rows", std::move(rows)}};
}

const json& at(const json& object, std::initializer_list<const char*> keys) {
  static const json nothing;
  const json* here = &object;
  for (const char* key : keys) {
    const auto it = here->is_object() ? here->find(key) : here->end();
    if (!here->is_object() || it == here->end()) return nothing;
    here = &*it;
  }
  return *here;
}

std::string number(const json& value, int places) {
  if (!value.is_number()) return "-";
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", places, value.get<double>());
  return text;
}

std::string text(const json& value, const char* fallback) {
  return value.is_string() ? value.get<std::string>() : fallback;
}

}  // namespace vacuform
