#include "worker/inspection/inspection.hpp"

namespace vacuform {

Result<Measured> measure(const FormedSheet& sheet, const Flattening& flattening, const Drawing& drawing,
                         const Placement& placement, const VectorPrint& print, const Alignment& alignment,
                         const CoilSettings& settings, const Context& context) {
  const std::vector<CoilLoops> loops = coil_loops(drawing, placement, print, flattening, alignment);
  VACUFORM_TRY(coils,
               measure_coils(sheet, flattening, loops, neighbours(loops, placement, drawing), context));
  return Measured{std::move(coils), measure_traces(sheet, flattening, print, settings.stretch_limit)};
}

}  // namespace vacuform
