// The common start of all forming studies: the mold and the warm sheet, as vacuform run makes them.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/scan/mold.hpp"
#include "worker/stage/context.hpp"
#include "worker/stage/input_file.hpp"

namespace vacuform {

struct Prepared {
  Mold mold;  // on its plug; it fits the machine
  TemperatureField temperature;
};

// Errors: those of check_inputs() and of the scan stage, does_not_fit, those of sheet_temperature().
Result<Prepared> prepare(const InputFile& scan, const Settings& settings,
                         const std::optional<InputFile>& temperature, const Context& context);

}  // namespace vacuform
