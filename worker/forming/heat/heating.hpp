// The sheet under the machine's heaters: what each place receives, how warm it becomes through its thickness, and how it
// cools on the way to the mold.
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

// On a raster of about 5 mm (at most 121 a side), each place a slab of its own. What lies under the clamp frame gets the
// temperature of the nearest place that does not. heat.seconds auto heats until the mean over the window will be
// heat.temperature_c on the mold, to 0.05 degrees. Deterministic on any number of threads.
// Errors: bad_settings when the heaters never reach the temperature; cancelled.
Result<HeatedSheet> heat_sheet(const SheetSettings& sheet, const MachineSettings& machine,
                               const HeatSettings& heat, const Context& context);

}  // namespace vacuform
