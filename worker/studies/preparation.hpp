// The common start of all forming studies: the mold and the warm sheet, as vacuform run makes them.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "api/settings.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/scan/mold.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct Prepared {
  Mold mold;  // on its plug; it fits the machine
  TemperatureField temperature;
};

// Errors: those of the scan stage, does_not_fit, those of sheet_temperature().
Result<Prepared> prepare(std::span<const std::uint8_t> scan, const std::string& scan_name,
                         const Settings& settings, const std::optional<MeasuredFile>& temperature,
                         const Context& context);

}  // namespace vacuform
