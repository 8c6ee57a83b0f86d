// The sheet under the heaters of the machine: the radiation that each place receives, its temperature through the
// thickness, and how it cools on the way to the mold.
#pragma once

#include "api/settings.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct HeatedSheet {
  TemperatureField field;    // when it meets the mold
  double seconds;            // under the heaters
  double through_thickness;  // largest difference in temperature between layers of one place, then
};

// On a raster of about 5 mm (at most 121 per side), each place is a separate slab. Places under the clamp frame get the
// temperature of the nearest place that is not under it. heat.seconds auto heats until the mean over the window will be
// heat.temperature_c on the mold, to 0.05 degrees. Deterministic on any number of threads. Errors: bad_settings if the
// heaters never reach the temperature; cancelled.
Result<HeatedSheet> heat_sheet(const SheetSettings& sheet, const MachineSettings& machine,
                               const HeatSettings& heat, const Context& context);

}  // namespace vacuform
