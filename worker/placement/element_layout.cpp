#include "worker/placement/element_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Moves a centre that lies beyond the chart from the nearest point of the chart by `way`, chart millimetres that are
// taken along the surface.
void go_beyond(const ChartedSurface& charted, Centre& centre, const Vector2d& way) {
  const InkedSurface& surface = charted.surface();
  const Vector3d axis = centre.axis;
  centre.axis = charted.axis(centre.point.triangle);
  const double turn = angle_between(surface, centre.point.triangle, centre.axis, axis);
  move(surface, centre, way);
  centre.axis = turned(surface, centre.point.triangle, centre.axis, turn);
  centre.moved.setZero();
}

// The elements with places of their own: coils, one about each centre, or everything if there is no coil. The others get
// their leaders.
std::vector<int> choose_leaders(ElementLayout& layout) {
  std::vector<int> leaders;
  const int count = static_cast<int>(layout.elements.size());
  const auto drawn = [&](int i) -> const Vector2d& { return layout.centres[index(i)].drawn; };
  const auto nearest = [&](int i) {
    return *std::min_element(leaders.begin(), leaders.end(), [&](int a, int b) {
      return (drawn(a) - drawn(i)).squaredNorm() < (drawn(b) - drawn(i)).squaredNorm();
    });
  };
  constexpr double same_mm = 1e-6;
  for (int i = 0; i < count; ++i) {
    LaidElement& element = layout.elements[index(i)];
    if (!element.outline.is_loop()) continue;
    if (!leaders.empty() && (drawn(nearest(i)) - drawn(i)).norm() < same_mm)
      element.leader = nearest(i);
    else
      leaders.push_back(i);
  }
  const bool coils = !leaders.empty();
  for (int i = 0; i < count; ++i)
    if (LaidElement& element = layout.elements[index(i)]; !element.outline.is_loop()) {
      if (coils)
        element.leader = nearest(i);
      else
        leaders.push_back(i);
    }
  return leaders;
}

Result<ElementOnSurface> lay(const ChartedSurface& charted, const LaidElement& element, const Centre& centre,
                             double turn, CoilKeep keep, bool rough) {
  // This may run on any thread, so the caller reports progress and checks for cancellation.
  VACUFORM_TRY(patch, element_patch(charted, centre.point,
                                    turned(charted.surface(), centre.point.triangle, centre.axis, turn),
                                    element.size * element.outline.reach_mm, keep, Context(), rough));
  ElementOnSurface laid;
  laid.turn = turn;
  laid.patch = std::move(patch);
  const ElementMap map(laid.patch);
  laid.on_head = std::all_of(element.outline.points.begin(), element.outline.points.end(),
                             [&](const Vector2d& p) { return map.on_chart(element.size * p); });
  laid.loop = loop_in_space(map, element);
  return laid;
}

}  // namespace

ElementLayout lay_by_chart(const ChartedSurface& charted, const Drawing& drawing,
                           const Alignment& alignment) {
  ElementLayout out;
  const auto axis = [&](int t) {
    return turned(charted.surface(), t, charted.axis(t), alignment.turn_deg * M_PI / 180);
  };
  const auto origin = charted.at_chart(alignment.chart({0, 0}), alignment.centre);
  if (origin.off_mm == 0) out.origin = Centre{origin.point, axis(origin.point.triangle)};
  for (std::size_t i = 0; i < drawing.elements.size(); ++i) {
    const Element& element = drawing.elements[i];
    if (element.id.empty()) continue;
    LaidElement laid{static_cast<int>(i), outline(element, alignment.scale), 1};
    const Vector2d wanted = alignment.chart(element.centre);
    const auto found = charted.at_chart(wanted, alignment.centre);
    if (found.off_mm > laid.outline.reach_mm) {
      out.left_out.push_back(static_cast<int>(i));
      continue;
    }
    Centre centre;
    centre.point = found.point;
    centre.axis = axis(found.point.triangle);
    centre.drawn = alignment.scale * element.centre;
    centre.radius_mm = laid.outline.radius_mm;
    if (found.off_mm > 0) go_beyond(charted, centre, wanted - charted.chart(found.point));
    out.elements.push_back(std::move(laid));
    out.centres.push_back(centre);
  }
  out.pairs = neighbours(out.centres, choose_leaders(out));
  return out;
}

void follow_leaders(const ChartedSurface& charted, ElementLayout& layout) {
  if (std::none_of(layout.elements.begin(), layout.elements.end(),
                   [](const LaidElement& e) { return e.leader >= 0; }))
    return;
  const std::vector<double> turn = turns(charted, layout.centres, layout.pairs);
  for (std::size_t i = 0; i < layout.elements.size(); ++i) {
    const int leader = layout.elements[i].leader;
    if (leader < 0) continue;
    Centre& centre = layout.centres[i];
    const Vector2d drawn = centre.drawn;
    const double radius = centre.radius_mm;
    centre = layout.centres[index(leader)];
    const Vector2d moved = centre.moved;
    move(charted.surface(), centre, Eigen::Rotation2Dd(turn[index(leader)]) * Vector2d(drawn - centre.drawn));
    centre.drawn = drawn, centre.radius_mm = radius, centre.moved = moved;
  }
}

Result<std::vector<ElementOnSurface>> lay_on_surface(const ChartedSurface& charted,
                                                     const ElementLayout& layout, const Context& context,
                                                     bool rough) {
  const std::vector<double> free = turns(charted, layout.centres, layout.pairs);
  std::vector<double> turn = free;
  for (std::size_t i = 0; i < turn.size(); ++i)
    if (const int leader = layout.elements[i].leader; leader >= 0) turn[i] = free[index(leader)];
  return lay_turned(charted, layout, turn, context, rough);
}

Result<std::vector<ElementOnSurface>> lay_turned(const ChartedSurface& charted, const ElementLayout& layout,
                                                 const std::vector<double>& turn, const Context& context,
                                                 bool rough) {
  const int count = static_cast<int>(layout.elements.size());
  std::vector<Result<ElementOnSurface>> laid(layout.elements.size());
  constexpr int batch = 4;  // so that a cancellation takes effect soon
  for (int begin = 0; begin < count; begin += batch) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    in_parallel(begin, std::min(begin + batch, count), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        const auto k = static_cast<std::size_t>(i);
        laid[k] = lay(charted, layout.elements[k], layout.centres[k], turn[k], layout.keep, rough);
      }
    });
  }
  std::vector<ElementOnSurface> out;
  for (auto& one : laid) {
    VACUFORM_CHECK(one);
    out.push_back(std::move(*one));
  }
  return out;
}

}  // namespace vacuform
