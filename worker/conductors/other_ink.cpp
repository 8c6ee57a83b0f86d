#include "worker/conductors/other_ink.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/conductors/loop_path.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double flat_point_mm = 0.5, flat_tolerance_mm = 0.02, least_mm2 = 0.1;

Area all_ink(const Element& element) {
  std::vector<Ring> rings;
  for (const Shape& shape : element.shapes) {
    const auto add = [&](const Area& area) { rings.insert(rings.end(), area.begin(), area.end()); };
    if (shape.fill && shape.fill->ink() > 0) add(fill_area(shape.curves, shape.even_odd, flat_tolerance_mm));
    if (shape.stroke && shape.stroke->colour.ink() > 0)
      add(stroke_area(shape.curves, *shape.stroke, flat_tolerance_mm));
  }
  return union_of(rings);
}

Area trace_band(const DrawnLoop& loop, double widest) {
  const LoopPath path(loop);
  Stroke stroke;
  stroke.width_mm = std::max(1.5, 1.1 * widest) * path.width();
  Curve curve = path.part(0, path.length());
  curve.closed = true;
  return stroke_area({curve}, stroke, flat_tolerance_mm);
}

// What lies on the patch.
std::optional<Ring> on_flat_sheet(const Ring& ring, const Patch& patch, const PlaneLocator& locator) {
  Ring out;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const int count = std::max(1, static_cast<int>(std::ceil((b - a).norm() / flat_point_mm)));
    for (int k = 0; k < count; ++k)
      if (const auto at = locator.find(a + (b - a) * k / count))
        out.push_back(interpolate(patch.triangles, *at, patch.rest));
  }
  return out.size() < 3 ? std::nullopt : std::optional(std::move(out));
}

}  // namespace

std::vector<LaidInkArea> ink_beside_traces(const std::vector<BuiltLayer>& layers,
                                           const std::vector<int>& faces, const std::vector<double>& widest,
                                           const PatchOf& patches) {
  std::vector<LaidInkArea> out;
  for (const BuiltLayer& layer : layers)
    for (std::size_t e = 0; e < layer.drawing.elements.size(); ++e) {
      const Element& element = layer.drawing.elements[e];
      if (element.shapes.empty()) continue;
      Area ink = all_ink(element);
      if (layer.step == PrintStep::conductor && layer.face == faces[e] && widest[e] > 0 && element.loop)
        ink = difference(ink, trace_band(*element.loop, widest[e]));
      if (square_mm(ink) < least_mm2) continue;
      LaidInkArea& laid = out.emplace_back(LaidInkArea{
          .element = static_cast<int>(e), .step = layer.step, .face = layer.face, .area = {}, .line = {}});
      for (const Patch* const patch : patches(e, layer.face)) {
        const PlaneLocator locator(patch->triangles, patch->uv);
        for (const Ring& ring : ink)
          if (auto flat = on_flat_sheet(ring, *patch, locator)) laid.area.push_back(*std::move(flat));
      }
    }
  return out;
}

}  // namespace vacuform
