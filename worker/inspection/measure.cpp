#include "worker/inspection/coil_warnings.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/loop_figures.hpp"

namespace vacuform {

namespace {

std::optional<Measured::Elements> distortion_of_elements(const Placement& placement, double scale) {
  std::vector<const Patch*> patches;
  for (const PlacedElement& element : placement.elements)
    if (element.on_head) patches.push_back(&element.patch);
  if (patches.empty()) return {};
  return Measured::Elements{
      distortion(patches, [&](const Patch& p, std::size_t v) -> Eigen::Vector2d { return scale * p.uv[v]; }),
      distortion(patches, [](const Patch& p, std::size_t v) { return p.rest[v]; })};
}

}  // namespace

Result<Measured> measure(const ChartedSurface& charted, const Drawing& drawing, const Placement& placement,
                         const VectorPrint& print, const Alignment& alignment, const CoilSettings& settings,
                         const Context& context) {
  const std::vector<CoilLoops> loops = coil_loops(drawing, placement, print, charted.flattening(), alignment);
  const MeasuredSheet sheet(charted);
  const auto keep = placement.elements.empty() ? std::nullopt : std::optional(settings.keep);
  VACUFORM_TRY(coils, measure_coils(sheet, loops, neighbours(loops, placement, drawing), keep, context));
  Measured measured{std::move(coils), measure_traces(sheet, print, settings.stretch_limit),
                    distortion_of_elements(placement, alignment.scale)};
  measured.warnings = coil_warnings(measured.coils, settings.decouple);
  for (const Warning& warning : measured.traces.warnings) measured.warnings.push_back(warning);
  return measured;
}

}  // namespace vacuform
