#include "worker/pipeline/laid_pattern.hpp"

#include <utility>

#include "worker/coils/coupled_neighbours.hpp"
#include "worker/pattern/ink_checks.hpp"
#include "worker/pipeline/print_progress.hpp"
#include "worker/printing/colour_ink.hpp"

namespace vacuform {

Result<LaidPattern> lay_pattern(Pattern pattern, const Inputs& inputs, const ChartedSurface& charted,
                                const std::vector<Edge>& cuts, const Context& context) {
  const Settings& s = inputs.settings;
  LaidPattern laid{.pattern = std::move(pattern)};
  laid.lines = read_drawing(laid.pattern, laid.warnings);
  for (Warning& warning : check_ink(laid.pattern, laid.lines, s.pattern.scale, s.print.dpi))
    laid.warnings.push_back(std::move(warning));
  if (!laid.lines) laid.parts = parts_to_place(laid.pattern, s.pattern.placement, laid.warnings);
  const SubProgress placing(context, progress::placing), decoupling(context, progress::decoupling);
  VACUFORM_TRY(placement, place(charted, laid.placed(), s, placing.context(), cuts));
  if (laid.placed())
    VACUFORM_CHECK(add_couplings(charted, *laid.placed(), s, decoupling.context(), placement));
  laid.warnings.insert(laid.warnings.end(), placement.warnings.begin(), placement.warnings.end());
  if (laid.parts && s.coils.decouple) {  // the coils of lines are measured
    VACUFORM_TRY(pairs, coupled_loops(placement, *laid.placed(), decoupling.context().silent()));
    if (auto coupled = coupling_warning(pairs, true)) laid.warnings.push_back(*std::move(coupled));
  }
  laid.placement = std::move(placement);
  VACUFORM_TRY(alignment, align_flat(charted, s.pattern));
  laid.alignment = alignment;
  return laid;
}

Result<LaidPattern> lay_colours(const SheetColours& colours, const ChartedSurface& charted,
                                const SheetSettings& sheet, const Context& context) {
  const SubProgress placing(context, progress::placing);
  VACUFORM_TRY(picture, picture_of(colours, sheet, placing.context()));
  return LaidPattern{.pattern = std::move(picture),
                     .placement = lay_flat(charted),
                     .alignment = {.shift_mm = -charted.flattening().top_rest}};
}

Result<std::vector<Layer>> layers_of(const LaidPattern& laid, const std::optional<SheetColours>& colours,
                                     const InkedSurface& surface, const Settings& settings,
                                     const Context& context) {
  std::shared_ptr<const LayerSource> pattern;
  if (laid.lines) {
    const SubProgress pulling(context, progress::pulling_back);
    VACUFORM_TRY(lines,
                 drawing_layer(laid.pattern, *laid.lines, laid.placement, settings, pulling.context()));
    pattern = std::move(lines);
  } else {
    pattern = picture_layer(laid.pattern, laid.placement, laid.parts ? &*laid.parts : nullptr,
                            settings.print.compensate_ink);
  }
  std::vector<Layer> layers;
  const auto add = [&](std::shared_ptr<const LayerSource> source) {
    layers.push_back({.name = layers.empty() ? "print" : "colours",
                      .face = settings.pattern.inked_face,
                      .source = std::move(source)});
  };
  const bool alone = settings.pattern.source == PatternSource::scan;
  if (!alone) add(pattern);
  if (colours)
    add(colour_layer(printed_colours(*colours, surface, settings.print), alone ? pattern : nullptr));
  return layers;
}

}  // namespace vacuform
