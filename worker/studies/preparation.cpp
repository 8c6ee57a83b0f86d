#include "worker/studies/preparation.hpp"

#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/scan/plug.hpp"

namespace vacuform {

Result<Prepared> prepare(std::span<const std::uint8_t> scan, const std::string& scan_name,
                         const Settings& settings, const std::optional<MeasuredFile>& temperature,
                         const Context& context) {
  VACUFORM_TRY(cut, make_mold(scan, scan_name, settings.scan, context));
  VACUFORM_TRY(mold, on_plug(std::move(cut), settings.machine.plug_height_mm));
  VACUFORM_CHECK(check_fit(mold, settings.sheet, settings.machine));
  VACUFORM_TRY(warmth,
               sheet_temperature(settings.sheet, settings.machine, settings.heat, temperature, context));
  return Prepared{std::move(mold), std::move(warmth.field)};
}

}  // namespace vacuform
