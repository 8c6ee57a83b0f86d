#include "worker/studies/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/forming/process.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

constexpr double window_mm = 4, drape_mm = 5, edge_stiffer = 1.3, edge_colder = 10, stiffer = 1.5,
                 coarser = 2;

// One change. `apply` makes it, in one direction and, where that is not possible, in the other.
struct Change {
  std::string id, text;
  Settings settings;
  TemperatureField temperature;
};

bool fits(const Mold& mold, const Settings& s) {
  return check_fit(mold, s.sheet, s.machine) && settings_from_json(to_json(s));
}

TemperatureField colder_at_the_frame(const TemperatureField& field, const Settings& s) {
  const int columns = std::max(2, static_cast<int>(std::ceil(s.sheet.width_mm / 5)) + 1),
            rows = std::max(2, static_cast<int>(std::ceil(s.sheet.height_mm / 5)) + 1);
  std::vector<double> celsius;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2d at((static_cast<double>(i) / (columns - 1) - 0.5) * s.sheet.width_mm,
                               (static_cast<double>(j) / (rows - 1) - 0.5) * s.sheet.height_mm);
      celsius.push_back(field.at(at) - edge_colder * nearness_to_frame(at, s.machine));
    }
  return TemperatureField(s.sheet.width_mm, s.sheet.height_mm, columns, std::move(celsius));
}

std::vector<Change> changes(const Mold& mold, const Settings& nominal, const TemperatureField& temperature) {
  std::vector<Change> out;
  const auto add = [&](const char* id, std::string text, const Settings& s) {
    out.push_back({id, std::move(text), s, temperature});
  };
  const bool elastic = nominal.forming.model == FormingModel::membrane;

  const auto window = [&](double by) {
    Settings s = nominal;
    s.machine.window_width_mm += by, s.machine.window_height_mm += by;
    return s;
  };
  const bool smaller = fits(mold, window(-window_mm));
  add("window", "the frame's window " + decimal(window_mm, 0) + " mm " + (smaller ? "smaller" : "larger"),
      window(smaller ? -window_mm : window_mm));

  const auto drape = [&](double by) {
    Settings s = nominal;
    s.machine.drape_height_mm += by;
    return s;
  };
  const bool higher = fits(mold, drape(drape_mm));
  add("drape-height", "the frame stops " + decimal(drape_mm, 0) + " mm " + (higher ? "higher" : "lower"),
      drape(higher ? drape_mm : -drape_mm));

  Settings s = nominal;
  s.forming.edge_stiffness *= edge_stiffer;
  add("edge-stiffness", "the sheet 30 % stiffer at the frame", s);

  out.push_back({"edge-temperature", "the sheet " + decimal(edge_colder, 0) + " degrees colder at the frame",
                 nominal, colder_at_the_frame(temperature, nominal)});

  if (elastic) {
    s = nominal;
    const bool neo = nominal.forming.law == MembraneLaw::neo_hookean;
    s.forming.law = neo ? MembraneLaw::mooney_rivlin : MembraneLaw::neo_hookean;
    add("law", neo ? "Mooney-Rivlin instead of neo-Hookean" : "neo-Hookean instead of Mooney-Rivlin", s);
    // Only the ratio of the pressure to the modulus counts.
    s = nominal;
    s.machine.vacuum_kpa /= stiffer;
    add("modulus", "the whole sheet 50 % stiffer, or a third less vacuum", s);
  }

  s = nominal;
  s.sheet.resolution_mm *= coarser;
  add("resolution",
      "a grid of " + short_decimal(s.sheet.resolution_mm) + " mm in place of " +
          short_decimal(nominal.sheet.resolution_mm) + " mm",
      s);
  return out;
}

double to_micrometre(double mm) { return std::round(mm * 1000) / 1000 + 0.0; }

}  // namespace

Result<std::vector<Variant>> form_variants(const Mold& mold, const Settings& settings,
                                           const TemperatureField& temperature, const Context& context) {
  const auto all = changes(mold, settings, temperature);
  std::vector<Variant> out;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Change& c = all[k];
    out.push_back({c.id, c.text, {}});
    if (!fits(mold, c.settings)) continue;
    const double n = static_cast<double>(all.size());
    const SubProgress portion(context,
                              {Stage::forming, static_cast<double>(k) / n, static_cast<double>(k + 1) / n});
    auto sheet = form(mold, c.settings.sheet, c.settings.machine, c.settings.forming, c.temperature,
                      portion.context());
    if (sheet)
      out.back().sheet = std::move(*sheet);
    else if (sheet.error().code != Code::forming_failed)
      return tl::make_unexpected(sheet.error());
  }
  return out;
}

std::vector<PrintedCoil> printed_coils(const std::vector<CoilCentre>& centres, const FormedSheet& sheet,
                                       const Flattening& flattening,
                                       const std::vector<std::array<Eigen::Vector2d, 3>>& pattern_uv) {
  // Corners of their own: charts that meet at a seam have different coordinates there.
  std::vector<Eigen::Vector2d> uv;
  std::vector<Triangle> corners;
  for (const auto& of : pattern_uv) {
    const int first = static_cast<int>(uv.size());
    uv.insert(uv.end(), of.begin(), of.end());
    corners.push_back({first, first + 1, first + 2});
  }
  const PlaneLocator charts(corners, uv);
  std::vector<PrintedCoil> out;
  for (const CoilCentre& centre : centres) {
    out.push_back({centre.id, {}});
    if (auto at = charts.find(centre.uv)) {
      at->triangle = flattening.triangles[at->triangle];
      out.back().rest = interpolate(sheet.triangles, *at, sheet.rest);
    }
  }
  return out;
}

Json sensitivity_json(const FormedSheet& nominal, const std::vector<Variant>& variants,
                      const std::vector<PrintedCoil>& coils) {
  const SheetMap nominal_map(nominal);
  Json names = Json::array(), centres = Json::array(), rows = Json::array();
  for (const PrintedCoil& coil : coils) {
    names.push_back(coil.id);
    const auto centre = coil.rest ? nominal_map(*coil.rest) : std::nullopt;
    centres.push_back(
        centre ? Json{to_micrometre(centre->x()), to_micrometre(centre->y()), to_micrometre(centre->z())}
               : Json());
  }
  for (const Variant& variant : variants) {
    Json row = {{"id", variant.id}, {"text", variant.text}, {"mean_mm", nullptr}, {"max_mm", nullptr}};
    Json each = Json::array();
    double sum = 0, most = 0;
    int count = 0;
    const std::optional<SheetMap> map =
        variant.sheet ? std::optional<SheetMap>(*variant.sheet) : std::nullopt;
    for (const PrintedCoil& coil : coils) {
      const auto was = coil.rest ? nominal_map(*coil.rest) : std::nullopt;
      const auto is = coil.rest && map ? (*map)(*coil.rest) : std::nullopt;
      if (!was || !is) {
        each.push_back(nullptr);
        continue;
      }
      const double moved = (*is - *was).norm();
      sum += moved, most = std::max(most, moved), ++count;
      each.push_back(to_micrometre(moved));
    }
    if (count > 0) row["mean_mm"] = to_micrometre(sum / count), row["max_mm"] = to_micrometre(most);
    row["coils_mm"] = std::move(each);
    rows.push_back(std::move(row));
  }
  return {{"coils", std::move(names)}, {"centres_mm", std::move(centres)}, {"changes", std::move(rows)}};
}

}  // namespace vacuform
