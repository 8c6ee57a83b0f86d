// How warm the sheet is when it meets the mold, from whatever source the settings name.
#pragma once

#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// For report.json.
struct HeatSummary {
  HeatSource source = HeatSource::uniform;
  double least = 0, mean = 0, most = 0;     // degrees Celsius on the mold, over the window of the clamp frame
  std::optional<double> seconds;            // under the heaters
  std::optional<double> through_thickness;  // largest difference between layers of one place
};

struct SheetTemperature {
  TemperatureField field;
  HeatSummary summary;
  std::vector<Warning> warnings = {};  // "uneven-through": the layers of the sheet differ much
};

// heat.source uniform: heat.temperature_c; heaters: heat_sheet(); measured: read_measured_field() of `measured`, which
// is there for that source alone (check_inputs()). Errors: those of the two; cancelled.
Result<SheetTemperature> sheet_temperature(const SheetSettings& sheet, const MachineSettings& machine,
                                           const HeatSettings& heat, const std::optional<InputFile>& measured,
                                           const Context& context);

}  // namespace vacuform
