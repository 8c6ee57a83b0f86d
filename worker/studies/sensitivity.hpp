// Sensitivity of the print: how far each coil lands off when one parameter of the machine differs from its setting.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/studies/coil_centres.hpp"

namespace vacuform {

// The same sheet formed with one change.
struct Variant {
  std::string
      id;  // stable: "window", "drape-height", "edge-stiffness", "edge-temperature", "law", "modulus",
           // "resolution"
  std::string text;                  // for people, with the figure
  std::optional<FormedSheet> sheet;  // nothing if that does not fit or does not come to rest
};

// Forms the sheet once for each change: the window of the frame 4 mm smaller, the frame stopping 5 mm higher, the sheet
// 30 % stiffer at the frame, 10 degrees colder there, the other law of the membrane, 50 % stiffer everywhere, a grid
// twice as coarse. If the mold does not fit a change, or the settings do not allow it, it is made in the other
// direction. Models without a law or a modulus skip those. Deterministic. Errors: cancelled.
Result<std::vector<Variant>> form_variants(const Mold& mold, const Settings& settings,
                                           const TemperatureField& temperature, const Context& context);

// The centre of each coil on the flat sheet, by the nominal print. Coils off the chart have no centre.
struct PrintedCoil {
  std::string id;
  std::optional<Eigen::Vector2d> rest;
};
// `pattern_uv` as in Print.
std::vector<PrintedCoil> printed_coils(const std::vector<CoilCentre>& centres, const FormedSheet& sheet,
                                       const Flattening& flattening,
                                       const std::vector<std::array<Eigen::Vector2d, 3>>& pattern_uv);

// The table for report.json: per change the distances, in mm, between the place of the centre of each coil and its
// nominal place (`centres_mm`, on the mold); mean, largest, and one by one in the order of `coils` (null off the chart
// or off the sheet).
nlohmann::ordered_json sensitivity_json(const FormedSheet& nominal, const std::vector<Variant>& variants,
                                        const std::vector<PrintedCoil>& coils);

}  // namespace vacuform
