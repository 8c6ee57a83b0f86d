// Settings and measured temperatures.
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/settings.hpp"
#include "tests/fuzz/targets.hpp"
#include "worker/forming/heat/measured_field.hpp"

namespace vacuform::fuzz {

void read_settings(Bytes bytes) {
  const auto settings = settings_from_text(text(bytes));
  if (!settings) return require(settings.error().code == Code::bad_settings, "bad settings are called so");
  const std::string written = to_json(*settings).dump();
  const auto again = settings_from_text(written);
  require(again.has_value(), "settings that were written can be read");
  require(to_json(*again).dump() == written, "settings survive being written and read");
}

void read_temperature(Bytes bytes) {
  SheetSettings sheet;
  HeatSettings heat;
  heat.source = HeatSource::measured;
  heat.black_c = 20;
  heat.white_c = 200;
  const auto field = read_measured_field({bytes, "fuzz.csv"}, sheet, heat);
  if (!field) return require(field.error().code != Code::internal, "a bad table is no fault of Vacuform's");
  for (const double s : {-1.0, -0.5, 0.0, 0.31, 1.0})
    require(std::isfinite(field->at({s * sheet.width_mm, -s * sheet.height_mm})), "temperatures are finite");
}

}  // namespace vacuform::fuzz
