#include "worker/inspection/mold_marks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/scan/cutting.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double half_width_mm = 0.75, depth_mm = 1, wall_mm = 1, from_edge_mm = 2.5, from_middle_mm = 3;

using BaseOutline = std::vector<Vector2d>;
using Slot = std::array<Vector2d, 4>;  // counter-clockwise from above

double distance_to(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double f = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (a + f * d - p).norm();
}

// Inside of the outlines (by the even-odd rule) and a wall away from them.
bool well_inside(const Vector2d& p, const std::vector<BaseOutline>& outlines) {
  bool inside = false;
  for (const BaseOutline& outline : outlines)
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      if (distance_to(p, a, b) < wall_mm) return false;
      if ((a.y() <= p.y()) != (b.y() <= p.y()) &&
          p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
        inside = !inside;
    }
  return inside;
}

// How far the outlines reach along an axis from the middle; negative where they do not cross it.
double reach(const std::vector<BaseOutline>& outlines, const Vector2d& axis) {
  const Vector2d across(-axis.y(), axis.x());
  double farthest = -1;
  for (const BaseOutline& outline : outlines)
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      const double side_a = a.dot(across), side_b = b.dot(across);
      if ((side_a <= 0) != (side_b <= 0))
        farthest = std::max(farthest, (a + (b - a) * side_a / (side_a - side_b)).dot(axis));
    }
  return farthest;
}

Slot slot_at(const Vector2d& axis, double from, double to) {
  const Vector2d across(-axis.y(), axis.x());
  Slot slot{from * axis - half_width_mm * across, to * axis - half_width_mm * across,
            to * axis + half_width_mm * across, from * axis + half_width_mm * across};
  for (Vector2d& p : slot) p = p.cast<float>().cast<double>();
  return slot;
}

class Base {
 public:
  explicit Base(const TriangleMesh& mold) {
    above_.vertices = mold.vertices;
    for (const Triangle& t : mold.triangles) {
      const bool flat = std::all_of(t.begin(), t.end(), [&](int v) { return mold.vertices[v].z() == 0; });
      if (!flat) above_.triangles.push_back(t);
    }
    loops_ = border_loops(above_);
    for (const auto& loop : loops_) {
      BaseOutline& outline = outlines_.emplace_back();
      for (const int v : loop) {
        const Vector3d& p = mold.vertices[v];
        outline.push_back(p.head<2>());
        is_flat_ &= p.z() == 0;
      }
    }
    is_flat_ &= !loops_.empty() && above_.triangles.size() < mold.triangles.size();
  }

  bool is_flat() const { return is_flat_; }
  const std::vector<BaseOutline>& outlines() const { return outlines_; }

  // Whether there is space for the slot with a wall around and above it.
  bool takes(const Slot& slot) const {
    for (std::size_t k = 0; k < 4; ++k)
      for (double f = 0; f < 1; f += 0.02)
        if (!well_inside(slot[k] + f * (slot[(k + 1) % 4] - slot[k]), outlines_)) return false;
    const Vector2d low = slot[0].cwiseMin(slot[2]).array() - wall_mm,
                   high = slot[0].cwiseMax(slot[2]).array() + wall_mm;
    for (const Triangle& t : above_.triangles) {
      const auto corner = [&](std::size_t k) { return above_.vertices[t[k]]; };
      const Vector3d least = corner(0).cwiseMin(corner(1)).cwiseMin(corner(2));
      const Vector3d most = corner(0).cwiseMax(corner(1)).cwiseMax(corner(2));
      if (least.z() < depth_mm + wall_mm && (least.head<2>() - high).maxCoeff() < 0 &&
          (low - most.head<2>()).maxCoeff() < 0)
        return false;
    }
    return true;
  }

  void cut(const Slot& slot) {
    const int first = static_cast<int>(above_.vertices.size());
    for (const double z : {0.0, depth_mm})
      for (const Vector2d& p : slot) above_.vertices.emplace_back(p.x(), p.y(), z);
    loops_.push_back({first, first + 1, first + 2, first + 3});
    for (int k = 0; k < 4; ++k) {  // walls face the slot's middle
      const int a = first + k, b = first + (k + 1) % 4;
      above_.triangles.push_back({a, b + 4, b});
      above_.triangles.push_back({a, a + 4, b + 4});
    }
    above_.triangles.push_back({first + 4, first + 6, first + 5});
    above_.triangles.push_back({first + 4, first + 7, first + 6});
  }

  // The mold with the base closed around the slots; nothing where that fails.
  std::optional<TriangleMesh> closed() const {
    const auto cap = flat_cap(above_.vertices, loops_);
    if (!cap) return std::nullopt;
    TriangleMesh mesh = above_;
    mesh.triangles.insert(mesh.triangles.end(), cap->begin(), cap->end());
    drop_unused_vertices(mesh);
    if (!is_watertight(mesh)) return std::nullopt;
    return mesh;
  }

 private:
  TriangleMesh above_;  // all but the base
  std::vector<std::vector<int>> loops_;
  std::vector<BaseOutline> outlines_;
  bool is_flat_ = true;
};

}  // namespace

TriangleMesh marked_mold(const TriangleMesh& mold) {
  Base base(mold);
  if (!base.is_flat()) return mold;
  const std::vector<BaseOutline> outlines = base.outlines();
  bool marked = false;
  for (const Vector2d& axis : {Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1), Vector2d(0, -1)}) {
    const double length = axis.y() > 0 ? 20 : 10;
    for (double to = reach(outlines, axis) - from_edge_mm; to - length >= from_middle_mm; to -= 1)
      if (const Slot slot = slot_at(axis, to - length, to); base.takes(slot)) {
        base.cut(slot);
        marked = true;
        break;
      }
  }
  return marked ? base.closed().value_or(mold) : mold;
}

}  // namespace vacuform
