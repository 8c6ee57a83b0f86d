#include "worker/coils/placement.hpp"

#include <algorithm>
#include <cmath>

#include "worker/coils/alignment.hpp"
#include "worker/coils/element_layout.hpp"
#include "worker/coils/element_patch.hpp"
#include "worker/coils/inductance.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// The region of interest with the sheet's own triangles.
Patch chart_patch(const FormedSheet& sheet, const Flattening& flattening, const Alignment& alignment) {
  Patch patch;
  std::vector<int> local(sheet.rest.size(), -1);
  for (const int t : flattening.triangles) {
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = index(sheet.triangles[index(t)][k]);
      if (local[v] < 0) {
        local[v] = static_cast<int>(patch.uv.size());
        patch.uv.push_back(alignment.pattern(flattening.chart[v]));
        patch.rest.push_back(sheet.rest[v]);
        patch.inked.push_back(flattening.inked[v]);
      }
      corners[k] = local[v];
    }
    patch.triangles.push_back(corners);
  }
  return patch;
}

// "coil-1, coil-2 and 5 more"
std::string names(const Drawing& drawing, const std::vector<int>& elements) {
  constexpr std::size_t most = 8;
  std::string out;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i == most) return out + " and " + std::to_string(elements.size() - most) + " more";
    if (i > 0) out += i + 1 == elements.size() ? " and " : ", ";
    out += drawing.elements[index(elements[i])].id;
  }
  return out;
}

// What stays of the layout once every element has its patch.
struct Laid {
  std::vector<std::vector<Vector3d>> loops;
  std::vector<double> self_nh;
};

Result<Laid> lay_elements(const InkedSurface& surface, const Drawing& drawing, const ElementLayout& layout,
                          const Alignment& alignment, const Context& context, Placement& out) {
  Laid laid;
  std::vector<int> off, folded;
  const std::vector<double> turn = turns(surface, layout.centres, layout.pairs);
  for (std::size_t i = 0; i < layout.elements.size(); ++i) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    const LaidElement& element = layout.elements[i];
    const Centre& centre = layout.centres[i];
    VACUFORM_TRY(patch, element_patch(surface, centre.point,
                                      turned(surface, centre.point.triangle, centre.axis, turn[i]),
                                      element.size * element.outline.reach_mm, context));
    const PatchMap map(patch);
    PlacedElement placed;
    placed.element = element.element;
    placed.centre = surface.place(centre.point);
    placed.centre_rest = surface.rest(centre.point);
    placed.moved_mm = centre.moved.norm();
    placed.turned_deg = turn[i] * 180 / M_PI;
    placed.size = alignment.scale * element.size;
    placed.on_head = std::all_of(element.outline.points.begin(), element.outline.points.end(),
                                 [&](const Vector2d& p) { return map.on_chart(element.size * p); });
    if (!placed.on_head) off.push_back(element.element);
    if (!patch.smooth) folded.push_back(element.element);
    for (Vector2d& uv : placed.patch.uv)
      uv = drawing.elements[index(element.element)].centre + uv / placed.size;
    laid.loops.push_back(loop_in_space(map, element));
    laid.self_nh.push_back(
        laid.loops.back().empty()
            ? 0
            : self_inductance_nh(laid.loops.back(), element.size * element.outline.width_mm));
    placed.patch = std::move(patch.patch);
    for (Vector2d& uv : placed.patch.uv)
      uv = drawing.elements[index(element.element)].centre + uv / placed.size;
    out.elements.push_back(std::move(placed));
  }
  if (!off.empty())
    out.warnings.push_back({"coil-off-head", names(drawing, off) + (off.size() > 1 ? " do" : " does") +
                                                 " not lie wholly on the formed part"});
  if (!layout.left_out.empty())
    out.warnings.push_back(
        {"coil-left-out", names(drawing, layout.left_out) + (layout.left_out.size() > 1 ? " lie" : " lies") +
                              " off the formed part and " + (layout.left_out.size() > 1 ? "are" : "is") +
                              " not printed"});
  if (!folded.empty())
    out.warnings.push_back(
        {"coil-on-bumps", names(drawing, folded) + (folded.size() > 1 ? " lie" : " lies") +
                              " on bumps so steep that the straight ways from the centre cross"});
  return laid;
}

std::optional<double> coupling_of(const Laid& laid, const Neighbours& pair) {
  const auto &a = laid.loops[index(pair.a)], &b = laid.loops[index(pair.b)];
  if (a.empty() || b.empty()) return {};
  return mutual_inductance_nh(a, b) / std::sqrt(laid.self_nh[index(pair.a)] * laid.self_nh[index(pair.b)]);
}

Result<void> place_elements(const InkedSurface& surface, const Drawing& drawing, const Alignment& alignment,
                            const Context& context, Placement& out) {
  ElementLayout layout = lay_by_chart(surface, drawing, alignment);
  for (const Neighbours& n : layout.pairs) {
    PlacedPair pair{n.a, n.b, n.drawn_mm, 0, 0, {}, {}};
    pair.chart_mm = connect(surface, layout.centres[index(n.a)].point, layout.centres[index(n.b)].point).mm;
    out.pairs.push_back(pair);
  }
  VACUFORM_CHECK(equalise(surface, layout.centres, layout.pairs, context));
  VACUFORM_TRY(laid, lay_elements(surface, drawing, layout, alignment, context, out));
  double squares = 0;
  int counted = 0;
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    PlacedPair& pair = out.pairs[i];
    pair.mm = connect(surface, layout.centres[index(pair.a)].point, layout.centres[index(pair.b)].point).mm;
    pair.k_before = pair.k = coupling_of(laid, layout.pairs[i]);
    if (!out.elements[index(pair.a)].on_head || !out.elements[index(pair.b)].on_head) continue;
    squares += (pair.mm - pair.drawn_mm) * (pair.mm - pair.drawn_mm);
    ++counted;
  }
  if (counted > 0) out.spacing_rms_mm = std::sqrt(squares / counted);
  return {};
}

}  // namespace

Result<Placement> place(const FormedSheet& sheet, const Flattening& flattening, const Drawing* drawing,
                        const Settings& settings, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  const InkedSurface surface(sheet, flattening);
  VACUFORM_TRY(alignment, align(surface, settings.pattern));
  Placement out;
  out.chart = chart_patch(sheet, flattening, alignment);
  const bool elements = drawing && std::any_of(drawing->elements.begin(), drawing->elements.end(),
                                               [](const Element& e) { return !e.id.empty(); });
  if (settings.pattern.placement == PatternPlacement::elements && !elements)
    return fail(Code::unusable_pattern, "the drawing has no elements", "pattern.placement",
                "give an SVG whose coils are groups with an id, or pattern.placement=auto");
  if (elements && settings.pattern.placement != PatternPlacement::chart)
    VACUFORM_CHECK(place_elements(surface, *drawing, alignment, context, out));
  return out;
}

}  // namespace vacuform
