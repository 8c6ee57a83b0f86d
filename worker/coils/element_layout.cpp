#include "worker/coils/element_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/coils/inductance.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The way from the chart's nearest point to a centre beyond it, chart millimetres taken along the surface.
void go_beyond(const InkedSurface& surface, Centre& centre, const Vector2d& way) {
  const Vector3d axis = centre.axis;
  centre.axis = surface.chart_axis(centre.point.triangle);
  const double turn = angle_between(surface, centre.point.triangle, centre.axis, axis);
  move(surface, centre, way);
  centre.axis = turned(surface, centre.point.triangle, centre.axis, turn);
  centre.moved.setZero();
}

}  // namespace

ElementLayout lay_by_chart(const InkedSurface& surface, const Drawing& drawing, const Alignment& alignment) {
  ElementLayout out;
  for (std::size_t i = 0; i < drawing.elements.size(); ++i) {
    const Element& element = drawing.elements[i];
    if (element.id.empty()) continue;
    LaidElement laid{static_cast<int>(i), outline(element, alignment.scale), 1};
    const Vector2d wanted = alignment.chart(element.centre);
    const auto found = surface.at_chart(wanted);
    if (found.off_mm > laid.outline.reach_mm) {
      out.left_out.push_back(static_cast<int>(i));
      continue;
    }
    Centre centre;
    centre.point = found.point;
    centre.axis = turned(surface, found.point.triangle, surface.chart_axis(found.point.triangle),
                         alignment.turn_deg * M_PI / 180);
    centre.drawn = alignment.scale * element.centre;
    centre.radius_mm = laid.outline.radius_mm;
    if (found.off_mm > 0) go_beyond(surface, centre, wanted - surface.chart(found.point));
    out.elements.push_back(std::move(laid));
    out.centres.push_back(centre);
  }
  out.pairs = neighbours(out.centres);
  return out;
}

Result<std::vector<ElementOnSurface>> lay_on_surface(const InkedSurface& surface, const ElementLayout& layout,
                                                     const Context& context, bool rough) {
  std::vector<ElementOnSurface> out;
  const std::vector<double> turn = turns(surface, layout.centres, layout.pairs);
  for (std::size_t i = 0; i < layout.elements.size(); ++i) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    const LaidElement& element = layout.elements[i];
    const Centre& centre = layout.centres[i];
    VACUFORM_TRY(patch, element_patch(surface, centre.point,
                                      turned(surface, centre.point.triangle, centre.axis, turn[i]),
                                      element.size * element.outline.reach_mm, context, rough));
    ElementOnSurface laid;
    laid.turn = turn[i];
    laid.patch = std::move(patch);
    const PatchMap map(laid.patch);
    laid.on_head = std::all_of(element.outline.points.begin(), element.outline.points.end(),
                               [&](const Vector2d& p) { return map.on_chart(element.size * p); });
    laid.loop = loop_in_space(map, element);
    if (!laid.loop.empty())
      laid.self_nh = self_inductance_nh(laid.loop, element.size * element.outline.width_mm);
    out.push_back(std::move(laid));
  }
  return out;
}

std::optional<double> coupling(const ElementOnSurface& a, const ElementOnSurface& b) {
  if (a.loop.empty() || b.loop.empty()) return {};
  return mutual_inductance_nh(a.loop, b.loop) / std::sqrt(a.self_nh * b.self_nh);
}

}  // namespace vacuform
