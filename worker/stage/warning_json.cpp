#include "worker/stage/warning_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit + 0.0; }

Json marks_json(const Warning& warning) {
  Json marks = Json::array();
  for (const Warning::Mark& mark : warning.marks) {
    Json place = Json::array();
    for (const double mm : mark.place_mm) place.push_back(rounded(mm, 10));
    marks.push_back({{"place_mm", std::move(place)}, {"size_mm", rounded(mark.size_mm, 10)}});
  }
  return marks;
}

// The subject of a warning that names no place, by its stage.
std::string_view subject(Stage stage) {
  switch (stage) {
    case Stage::scan:
      return "the whole scan";
    case Stage::forming:
      return "the whole sheet";
    case Stage::flattening:
      return "the whole chart";
    case Stage::printing:
      return "the drawing";
    case Stage::inspection:
      return "the part";
  }
  return "";
}

std::string place_of(Stage stage, const Warning& warning) {
  if (!warning.place.empty()) return warning.place;
  if (warning.marks.empty()) return std::string(subject(stage));
  const auto& at = warning.marks.front().place_mm;
  std::string place =
      "x = " + decimal(at[0], 1) + ", y = " + decimal(at[1], 1) + ", z = " + decimal(at[2], 1) + " mm";
  const std::size_t more = warning.marks.size() - 1;
  if (more > 0) place += " and " + std::to_string(more) + (more == 1 ? " more place" : " more places");
  return place;
}

Json figure_json(const Warning& warning) {
  if (!warning.figure || !std::isfinite(warning.figure->value)) return nullptr;
  const Warning::Figure& figure = *warning.figure;
  return {{"value", rounded(figure.value, 1000)},
          {"unit", figure.unit},
          {"limit", figure.limit ? Json(rounded(*figure.limit, 1000)) : Json(nullptr)}};
}

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

}  // namespace

Json warning_json(Stage stage, const Warning& warning) {
  return {{"stage", name(stage)},
          {"code", warning.code},
          {"severity", name(warning.severity())},
          {"what", sentence(warning.text)},
          {"place", place_of(stage, warning)},
          {"figure", figure_json(warning)},
          {"fix", sentence(warning.what_to_do())},
          {"proposals", proposals_json(warning.proposals)},
          {"marks", marks_json(warning)}};
}

}  // namespace vacuform
