#include "worker/forming/heat/sheet_temperature.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "api/base/decimal.hpp"
#include "worker/forming/heat/heating.hpp"
#include "worker/forming/heat/window.hpp"
#include "worker/forming/material.hpp"

namespace vacuform {

namespace {

constexpr double much_through_thickness = 20;  // degrees: as much as half a forming window

Result<SheetTemperature> by_source(const SheetSettings& sheet, const MachineSettings& machine,
                                   const HeatSettings& heat, const std::optional<MeasuredFile>& measured,
                                   const Context& context) {
  switch (heat.source) {
    case HeatSource::uniform:
      return SheetTemperature{
          TemperatureField(heat.temperature_c.value_or(material_profile(sheet.material).forming_celsius())),
          {}};
    case HeatSource::heaters: {
      VACUFORM_TRY(heated, heat_sheet(sheet, machine, heat, context));
      SheetTemperature out{std::move(heated.field), {}};
      out.summary.seconds = heated.seconds;
      out.summary.through_thickness = heated.through_thickness;
      if (heated.through_thickness > much_through_thickness)
        out.warnings.push_back({"uneven-through",
                                "Through its thickness the sheet differs by up to " +
                                    decimal(heated.through_thickness, 0) + " degrees when it meets the mold",
                                {},
                                Warning::Figure{heated.through_thickness, "C", much_through_thickness}});
      return out;
    }
    case HeatSource::measured: {
      VACUFORM_TRY(field, read_measured_field(*measured, sheet, heat));
      return SheetTemperature{std::move(field), {}};
    }
  }
  std::abort();
}

// On a raster of 201 a side; the ends of the window are on it.
void summarize(SheetTemperature& temperature, const MachineSettings& machine) {
  HeatSummary& s = temperature.summary;
  constexpr int steps = 200;
  const double width = machine.window_width_mm;
  const double height = machine.window == WindowShape::circle ? width : machine.window_height_mm;
  double sum = 0, area = 0;
  s.least = INFINITY, s.most = -INFINITY;
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d place((static_cast<double>(i) / steps - 0.5) * width,
                                  (static_cast<double>(j) / steps - 0.5) * height);
      if (!in_window(place, machine)) continue;
      const double celsius = temperature.field.at(place);
      const double weight = (i % steps == 0 ? 0.5 : 1) * (j % steps == 0 ? 0.5 : 1);
      s.least = std::min(s.least, celsius), s.most = std::max(s.most, celsius);
      sum += weight * celsius, area += weight;
    }
  s.mean = sum / area;
}

}  // namespace

Result<SheetTemperature> sheet_temperature(const SheetSettings& sheet, const MachineSettings& machine,
                                           const HeatSettings& heat,
                                           const std::optional<MeasuredFile>& measured,
                                           const Context& context) {
  if (heat.source == HeatSource::measured && !measured)
    return fail(Code::bad_settings, "there is no file of measured temperatures", "heat.source",
                "give one as --temperature FILE, or choose another source");
  if (heat.source != HeatSource::measured && measured)
    return fail(Code::bad_usage, "measured temperatures are given, but the settings take them from elsewhere",
                "heat.source", "set heat.source to measured, or leave the file out");
  VACUFORM_TRY(temperature, by_source(sheet, machine, heat, measured, context));
  temperature.summary.source = heat.source;
  summarize(temperature, machine);
  return temperature;
}

std::vector<Warning> temperature_findings(const FormedSheet& sheet, Material material) {
  const MaterialProfile profile = material_profile(material);
  std::string plastic(name(material));
  std::transform(plastic.begin(), plastic.end(), plastic.begin(),
                 [](char c) { return static_cast<char>(c - 'a' + 'A'); });
  std::vector<Warning> warnings;
  const auto look = [&](const char* code, const char* comparative, const char* consequence, auto&& excess) {
    std::vector<int> out;
    double free = 0;
    for (std::size_t v = 0; v < sheet.temperature.size(); ++v) {
      if (sheet.contact[v] == Contact::clamp) continue;
      free += 1;
      if (excess(sheet.temperature[v]) > 0.05) out.push_back(static_cast<int>(v));
    }
    if (out.empty()) return;
    std::stable_sort(out.begin(), out.end(), [&](int a, int b) {
      return excess(sheet.temperature[static_cast<std::size_t>(a)]) >
             excess(sheet.temperature[static_cast<std::size_t>(b)]);
    });
    const auto worst = static_cast<std::size_t>(out.front());
    const Eigen::Vector3d& p = sheet.formed[worst];
    const double share = 100 * static_cast<double>(out.size()) / free;
    Warning warning{
        code, "The sheet is up to " + decimal(std::max(1.0, excess(sheet.temperature[worst])), 0) +
                  " degrees " + comparative + " than " + plastic + " forms (" +
                  decimal(profile.coldest_celsius, 0) + " to " + decimal(profile.hottest_celsius, 0) +
                  " C): " + decimal(sheet.temperature[worst], 0) + " C at x = " + decimal(p.x(), 0) +
                  " mm, y = " + decimal(p.y(), 0) + " mm, z = " + decimal(p.z(), 0) + " mm, outside over " +
                  (share < 1 ? std::string("less than 1") : decimal(share, 0)) + " % of it; " + consequence};
    warning.figure =
        Warning::Figure{sheet.temperature[worst], "C",
                        sheet.temperature[worst] < profile.coldest_celsius ? profile.coldest_celsius
                                                                           : profile.hottest_celsius};
    constexpr double apart_mm = 40;
    for (const int v : out) {
      const Eigen::Vector3d& q = sheet.formed[static_cast<std::size_t>(v)];
      const bool near = std::any_of(warning.marks.begin(), warning.marks.end(), [&](const Warning::Mark& m) {
        return (Eigen::Vector3d(m.place_mm[0], m.place_mm[1], m.place_mm[2]) - q).norm() < apart_mm;
      });
      if (!near) warning.marks.push_back({{q.x(), q.y(), q.z()}});
      if (warning.marks.size() == Warning::most_marks) break;
    }
    warnings.push_back(std::move(warning));
  };
  look("too-cold", "colder", "it tears there or does not follow the mold",
       [&](double celsius) { return profile.coldest_celsius - celsius; });
  look("too-hot", "hotter", "it sags, blisters or thins there",
       [&](double celsius) { return celsius - profile.hottest_celsius; });
  return warnings;
}

}  // namespace vacuform
