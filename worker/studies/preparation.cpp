#include "worker/studies/preparation.hpp"

#include "api/job_inputs.hpp"
#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/scan/plug.hpp"

namespace vacuform {

Result<Prepared> prepare(const InputFile& scan, const Settings& settings,
                         const std::optional<InputFile>& temperature, const Context& context) {
  VACUFORM_CHECK(check_inputs(
      JobKind::layout,
      [&](std::string_view name) { return name == "scan" || (name == "temperature" && temperature); },
      settings));
  VACUFORM_TRY(cut, make_mold(scan.bytes, scan.name, settings.scan, context));
  VACUFORM_TRY(mold, on_plug(std::move(cut), settings.machine.plug_height_mm));
  VACUFORM_CHECK(check_fit(mold, settings.sheet, settings.machine));
  VACUFORM_TRY(warmth,
               sheet_temperature(settings.sheet, settings.machine, settings.heat, temperature, context));
  return Prepared{std::move(mold), std::move(warmth.field)};
}

}  // namespace vacuform
