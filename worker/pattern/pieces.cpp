#include "worker/pattern/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "worker/numerics/disjoint_sets.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr std::size_t most_compared = 2000;  // curves of a fill

// The curves of a fill in groups that do not touch each other's boxes.
std::vector<std::vector<std::size_t>> apart(const std::vector<Curve>& curves) {
  DisjointSets sets(curves.size());
  std::vector<AlignedBox2d> boxes;
  for (const Curve& curve : curves) boxes.push_back(box_of(curve));
  for (std::size_t a = 0; a < curves.size(); ++a)
    for (std::size_t b = a + 1; b < curves.size(); ++b)
      if (boxes[a].intersects(boxes[b])) sets.join(static_cast<int>(a), static_cast<int>(b));
  std::map<int, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < curves.size(); ++i) groups[sets.root(static_cast<int>(i))].push_back(i);
  std::vector<std::vector<std::size_t>> out;
  for (auto& [root, group] : groups) out.push_back(std::move(group));
  return out;
}

}  // namespace

// A line that runs back on itself fills nothing.
bool has_filled(const Shape& s) {
  if (!s.fill || !(s.fill->ink() > 0)) return false;
  return std::any_of(s.curves.begin(), s.curves.end(), [](const Curve& curve) {
    double twice = 0, most = 0;
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      const Vector2d p = curve.points[i] - curve.points.front();
      const double area = cross(p, curve.points[(i + 1) % curve.points.size()] - curve.points.front());
      twice += area, most = std::max(most, std::abs(area));
    }
    return std::max(std::abs(twice), most) > 1e-9;
  });
}
bool has_stroked(const Shape& s) { return s.stroke && s.stroke->colour.ink() > 0; }

AlignedBox2d box_of_shape(const Shape& shape) {
  AlignedBox2d box;
  for (const Curve& curve : shape.curves) box.extend(box_of(curve));
  return box;
}

std::vector<Shape> pieces_of(Shape shape) {
  if (shape.curves.size() < 2) return {std::move(shape)};
  std::vector<Shape> out;
  if (shape.fill) {
    Shape fill = shape;
    fill.stroke.reset();
    if (fill.curves.size() > most_compared) {
      out.push_back(std::move(fill));
    } else {
      for (const auto& group : apart(shape.curves)) {
        fill.curves.clear();
        for (const std::size_t i : group) fill.curves.push_back(shape.curves[i]);
        out.push_back(fill);
      }
    }
  }
  if (!shape.stroke) return out;
  shape.fill.reset();
  if (shape.stroke->colour.a < 1) {
    out.push_back(std::move(shape));
    return out;
  }
  std::vector<Curve> curves = std::move(shape.curves);
  for (Curve& curve : curves) {
    shape.curves = {std::move(curve)};
    out.push_back(shape);
  }
  return out;
}

double ink_mm2(const Shape& shape) {
  Area area;
  if (has_filled(shape)) area = fill_area(shape.curves, shape.even_odd, 0.002);
  if (has_stroked(shape)) {
    const Area line = stroke_area(shape.curves, *shape.stroke, 0.002);
    area.insert(area.end(), line.begin(), line.end());
  }
  return area.empty() ? 0 : square_mm(union_of(area));
}

}  // namespace vacuform
