#include "worker/conductors/interrupted.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "worker/pattern/clipping.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double tolerance_mm = 0.002;

Eigen::AlignedBox2d box_of(const Area& area) {
  Eigen::AlignedBox2d box;
  for (const Ring& ring : area)
    for (const Vector2d& p : ring) box.extend(p);
  return box;
}

std::vector<Curve> outlines(const Area& area) {
  std::vector<Curve> out;
  for (const Ring& ring : area) {
    std::vector<Vector2d> points = ring;
    points.push_back(ring.front());
    out.push_back(straight_curve(points));
    out.back().closed = true;
  }
  return out;
}

// Of a closed curve: parts that meet at its beginning are one.
std::vector<std::vector<Vector2d>> parts_outside(const Curve& curve, const Area& removed) {
  std::vector<Vector2d> line;
  for (const CurvePoint& p : flatten(curve, {.tolerance_mm = tolerance_mm})) line.push_back(p.at);
  if (line.size() < 2) return {};
  auto parts = line_outside(line, removed);
  if (!curve.closed || parts.size() < 2) return parts;
  const auto meets = [&](const Vector2d& p) { return (p - line.front()).norm() < 1e-4; };
  std::size_t first = parts.size(), last = parts.size();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    // The library gives lines in either direction.
    if (meets(parts[i].front()) || meets(parts[i].back())) (first == parts.size() ? first : last) = i;
  }
  if (last == parts.size()) return parts;
  if (meets(parts[first].front())) std::reverse(parts[first].begin(), parts[first].end());
  if (meets(parts[last].back())) std::reverse(parts[last].begin(), parts[last].end());
  parts[first].insert(parts[first].end(), parts[last].begin() + 1, parts[last].end());
  parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(last));
  return parts;
}

void add_stroke(const Shape& shape, const Area& removed, std::vector<Shape>& out) {
  Stroke stroke = *shape.stroke;
  if (!stroke.dashes_mm.empty()) {
    out.push_back({.curves = outlines(difference(stroke_area(shape.curves, stroke, tolerance_mm), removed)),
                   .fill = stroke.colour,
                   .stroke = {}});
    return;
  }
  std::vector<Curve> whole, parts;
  for (const Curve& curve : shape.curves) {
    if (!vacuform::box_of(curve).intersects(box_of(removed))) {
      whole.push_back(curve);
      continue;
    }
    for (const auto& part : parts_outside(curve, removed)) parts.push_back(straight_curve(part));
  }
  if (!whole.empty()) out.push_back({.curves = std::move(whole), .fill = {}, .stroke = stroke});
  stroke.cap = LineCap::butt;
  if (!parts.empty()) out.push_back({.curves = std::move(parts), .fill = {}, .stroke = std::move(stroke)});
}

}  // namespace

Area band(const LoopPath& path, const std::vector<Interval>& intervals) {
  Stroke stroke;
  stroke.width_mm = 1.5 * path.width();
  std::vector<Curve> parts;
  for (const Interval& each : intervals) parts.push_back(path.part(each.from, each.to));
  return stroke_area(parts, stroke, tolerance_mm);
}

std::vector<Shape> interrupted(const std::vector<Shape>& shapes, const Area& removed) {
  if (removed.empty()) return shapes;
  std::vector<Shape> out;
  for (const Shape& shape : shapes) {
    if (shape.fill)
      out.push_back(
          {.curves = outlines(difference(fill_area(shape.curves, shape.even_odd, tolerance_mm), removed)),
           .fill = shape.fill,
           .stroke = {}});
    if (shape.stroke) add_stroke(shape, removed, out);
  }
  return out;
}

Shape along_loop(const LoopPath& path, const Interval& part, double width_mm) {
  Stroke stroke;
  stroke.width_mm = width_mm;
  return {.curves = {path.part(part.from, part.to)}, .fill = {}, .stroke = std::move(stroke)};
}

}  // namespace vacuform
