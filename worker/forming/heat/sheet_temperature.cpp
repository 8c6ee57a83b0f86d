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
                                   const HeatSettings& heat, const std::optional<InputFile>& measured,
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
      VACUFORM_TRY(field, read_measured_field(measured.value(), sheet, heat));
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
                                           const HeatSettings& heat, const std::optional<InputFile>& measured,
                                           const Context& context) {
  VACUFORM_TRY(temperature, by_source(sheet, machine, heat, measured, context));
  temperature.summary.source = heat.source;
  summarize(temperature, machine);
  return temperature;
}

}  // namespace vacuform
