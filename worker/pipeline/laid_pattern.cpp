#include "worker/pipeline/laid_pattern.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "worker/coils/coupled_neighbours.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/pattern/ink_checks.hpp"
#include "worker/pipeline/print_progress.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/laid_areas.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

Result<void> build_loops(LaidPattern& laid, const SheetSides& sides, const std::optional<BodyBelow>& body,
                         const Settings& settings, const Context& context) {
  const bool asked = settings.coils.build != CoilBuild::single || settings.coils.gaps > 0 ||
                     settings.coils.gap_rule != GapRule::count || settings.print.compensate_width ||
                     settings.coils.tails != TailExit::none;
  const bool loops =
      laid.lines && std::any_of(laid.placement.elements.begin(), laid.placement.elements.end(),
                                [&](const PlacedElement& placed) {
                                  return laid.lines->elements[index(placed.element)].loop.has_value();
                                });
  const bool layered = laid.lines && laid.lines->layered();
  if (asked && !loops)
    return fail(Code::unusable_pattern,
                "there are no loops to build: only coils that are drawn as lines are built",
                settings.coils.gaps > 0                     ? "coils.gaps"
                : settings.coils.gap_rule != GapRule::count ? "coils.gap_rule"
                : settings.coils.build != CoilBuild::single ? "coils.build"
                : settings.coils.tails != TailExit::none    ? "coils.tails"
                                                            : "print.compensate_width",
                "give a vector drawing of coils that are placed one by one, or leave the setting out");
  if (!loops && !layered) return {};
  VACUFORM_TRY(build, build_array(*laid.lines, laid.placement, sides, body, settings, context));
  laid.warnings.insert(laid.warnings.end(), build.warnings.begin(), build.warnings.end());
  // What measures the loops takes them as wide as they are printed.
  for (std::size_t e = 0; e < build.widened.size(); ++e)
    if (auto& loop = laid.lines->elements[e].loop) loop->width_mm *= build.widened[e].mean;
  laid.build = std::move(build);
  return {};
}

std::string_view name_of(const BuiltLayer& layer) {
  constexpr std::array<std::array<std::string_view, 3>, 2> names{
      {{"print", "print-dielectric", "print-bridges"},
       {"print-reverse", "print-reverse-dielectric", "print-reverse-bridges"}}};
  return names[index(layer.face)][static_cast<std::size_t>(layer.step)];
}

// From what is seen first from the outside: on the outer face what is printed last.
void sort_by_sight(std::vector<Layer>& layers, const std::vector<BuiltLayer>& built) {
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t i = 0; i < built.size(); ++i) {
    const int step = static_cast<int>(built[i].step);
    order.emplace_back(layers[i].face == InkedFace::outer ? -step : 1 + step, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<Layer> sorted;
  for (const auto& [depth, i] : order) sorted.push_back(std::move(layers[i]));
  layers = std::move(sorted);
}

// Of the gaps in the conductors of a layer, and beside the pads of a tail that of its port.
std::vector<PlaceNumber> numbers_on(const ArrayBuild& build, const BuiltLayer& layer) {
  std::vector<PlaceNumber> out;
  if (layer.step != PrintStep::conductor) return out;
  for (const LoopGap& gap : build.gaps)
    if (build.faces[index(gap.coil)] == layer.face) out.push_back({gap.number, gap.rest, gap.inwards});
  for (const Tail& tail : build.tails)
    if (build.faces[index(tail.coil)] == layer.face) out.push_back({tail.number, tail.rest, tail.onwards});
  return out;
}

Result<std::vector<Layer>> layers_of_build(const LaidPattern& laid, const Settings& settings,
                                           const Context& context) {
  const ArrayBuild& build = *laid.build;
  std::vector<Layer> layers;
  const auto share = [&](std::size_t n) {
    return static_cast<double>(n) / static_cast<double>(build.layers.size());
  };
  for (const BuiltLayer& built : build.layers) {
    const SubProgress part(context, {Stage::printing, share(layers.size()), share(layers.size() + 1)});
    VACUFORM_TRY(vectors, pull_back(built.drawing, build.placement(built.face, laid.placement), settings,
                                    part.context()));
    add_laid_ink(built.laid, vectors);
    const InkedFace face = settings.pattern.inked_face;
    layers.push_back({.name = std::string(name_of(built)),
                      .face = built.face == 0 ? face : other_face(face),
                      .source = drawing_layer(laid.pattern, std::move(vectors)),
                      .step = build.layers.size() > 1 ? std::optional(built.step) : std::nullopt,
                      .numbers = numbers_on(build, built)});
  }
  sort_by_sight(layers, build.layers);
  return layers;
}

}  // namespace

Result<LaidPattern> lay_pattern(Pattern pattern, const Inputs& inputs, const ChartedSurface& charted,
                                const ChartedSurface& reverse, const std::optional<BodyBelow>& body,
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
  VACUFORM_CHECK(build_loops(laid, {charted, reverse}, body, s, decoupling.context().silent()));
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
  std::vector<Layer> layers;
  if (laid.build) {
    const SubProgress pulling(context, progress::pulling_back);
    VACUFORM_TRY(built, layers_of_build(laid, settings, pulling.context()));
    layers = std::move(built);
  }
  std::shared_ptr<const LayerSource> pattern;
  if (laid.lines && !laid.build) {
    const SubProgress pulling(context, progress::pulling_back);
    VACUFORM_TRY(lines,
                 drawing_layer(laid.pattern, *laid.lines, laid.placement, settings, pulling.context()));
    pattern = std::move(lines);
  } else if (!laid.build) {
    pattern = picture_layer(laid.pattern, laid.placement, laid.parts ? &*laid.parts : nullptr,
                            settings.print.compensate_ink);
  }
  const auto add = [&](std::shared_ptr<const LayerSource> source) {
    layers.push_back({.name = layers.empty() ? "print" : "colours",
                      .face = settings.pattern.inked_face,
                      .source = std::move(source)});
  };
  const bool alone = settings.pattern.source == PatternSource::scan;
  if (!alone && pattern) add(pattern);
  if (colours)
    add(colour_layer(printed_colours(*colours, surface, settings.print), alone ? pattern : nullptr));
  return layers;
}

}  // namespace vacuform
