#include "worker/inspection/coil_warnings.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/loop_figures.hpp"

namespace vacuform {

namespace {

std::optional<Both<Distortion>> distortion_of_elements(const Placement& placement, double scale) {
  std::vector<const Patch*> patches;
  for (const PlacedElement& element : placement.elements)
    if (element.on_head) patches.push_back(&element.patch);
  if (patches.empty()) return {};
  return Both<Distortion>{
      .without = distortion(patches, [](const Patch& p, std::size_t v) { return p.rest[v]; }),
      .with = distortion(patches,
                         [&](const Patch& p, std::size_t v) -> Eigen::Vector2d { return scale * p.uv[v]; })};
}

}  // namespace

Result<Measured> measure(const ChartedSurface& charted, const PrintedDrawing& printed,
                         const CoilSettings& settings, const Context& context) {
  const auto& [drawing, placement, vectors, alignment, other, faces] = printed;
  const std::vector<CoilLoops> loops =
      coil_loops(drawing, placement, vectors, charted.flattening(), alignment, faces);
  const MeasuredSheet sheet(charted);
  std::optional<MeasuredSheet> reverse;
  if (other) reverse.emplace(*other);
  const auto keep = placement.elements.empty() ? std::nullopt : std::optional(settings.keep);
  VACUFORM_TRY(coils, measure_coils({sheet, reverse ? &*reverse : nullptr}, loops,
                                    neighbours(loops, placement, drawing), keep, context));
  Measured measured{std::move(coils), measure_traces(sheet, vectors, settings.stretch_limit),
                    distortion_of_elements(placement, alignment.scale)};
  measured.warnings = coil_warnings(measured.coils, settings.decouple);
  for (const Warning& warning : measured.traces.warnings) measured.warnings.push_back(warning);
  return measured;
}

}  // namespace vacuform
