#include "worker/forming/mold_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace vacuform {

namespace {

// An edge of the mesh with the faces on its sides; -1 where there is no face.
struct MoldEdge {
  int a, b, left, right;
};

std::vector<MoldEdge> mold_edges(const TriangleMesh& mesh) {
  struct Half {
    int a, b, face;
  };
  std::vector<Half> halves;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    for (int e = 0; e < 3; ++e) {
      const int a = mesh.triangles[k][e], b = mesh.triangles[k][(e + 1) % 3];
      halves.push_back({std::min(a, b), std::max(a, b), static_cast<int>(k)});
    }
  std::sort(halves.begin(), halves.end(), [](const Half& x, const Half& y) {
    return std::tie(x.a, x.b, x.face) < std::tie(y.a, y.b, y.face);
  });
  std::vector<MoldEdge> edges;
  for (std::size_t k = 0; k < halves.size();) {
    std::size_t end = k;
    while (end < halves.size() && halves[end].a == halves[k].a && halves[end].b == halves[k].b) ++end;
    edges.push_back({halves[k].a, halves[k].b, halves[k].face, end - k == 2 ? halves[k + 1].face : -1});
    k = end;
  }
  return edges;
}

}  // namespace

MoldPoints::MoldPoints(const TriangleMesh& mold, double spacing_mm, double drop_mm) {
  std::vector<Eigen::Vector3d> normal, found;
  std::vector<double> area;
  for (const Triangle& t : mold.triangles) {
    const Eigen::Vector3d a = mold.vertices[t[0]];
    const Eigen::Vector3d n = (mold.vertices[t[1]] - a).cross(mold.vertices[t[2]] - a);
    area.push_back(n.norm() / 2);
    normal.push_back(n.stableNormalized());
  }
  const double reach = spacing_mm / 2;
  std::vector<int> edges(mold.vertices.size(), 0);  // number of sharp edges at each vertex
  for (const MoldEdge& e : mold_edges(mold)) {
    const Eigen::Vector3d &a = mold.vertices[e.a], &b = mold.vertices[e.b];
    const double length = (b - a).norm();
    if (!(length > 0)) continue;
    if (e.right >= 0) {
      const Eigen::Vector3d &n = normal[e.left], &m = normal[e.right];
      // Convex if the far corner of one face lies below the other face.
      const Triangle& t = mold.triangles[e.right];
      const int far = t[0] != e.a && t[0] != e.b ? t[0] : t[1] != e.a && t[1] != e.b ? t[1] : t[2];
      if (n.dot(mold.vertices[far] - a) >= 0) continue;
      const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
      // The faces turn by `angle` over their mean height: a fillet within reach counts as a whole.
      const double height = (area[e.left] + area[e.right]) / length;
      const double turned = std::min(angle * std::max(1.0, reach / height), 0.9 * M_PI);
      if (reach * std::tan(turned / 2) * (height < reach ? 0.5 : 1.0) < drop_mm) continue;
    }
    ++edges[e.a], ++edges[e.b];
    const int parts = static_cast<int>(std::ceil(length / (spacing_mm / 4)));
    for (int k = 1; k < parts; ++k) found.push_back(a + (b - a) * k / parts);
  }
  std::vector<char> corner(found.size(), 0);
  for (std::size_t v = 0; v < edges.size(); ++v)
    if (edges[v] > 0) found.push_back(mold.vertices[v]), corner.push_back(edges[v] != 2);
  if (found.empty()) return;

  low_ = high_ = found.front();
  for (const auto& p : found) low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
  constexpr double most_cells = 2e6;
  const Eigen::Vector3d box = high_ - low_;
  size_ = std::max(spacing_mm, std::cbrt(std::max(box.x(), spacing_mm) * std::max(box.y(), spacing_mm) *
                                         std::max(box.z(), spacing_mm) / most_cells));
  count_ = (box / size_).cast<int>() + Eigen::Vector3i::Ones();
  const auto number = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3i c = cell(p);
    return (static_cast<std::size_t>(c.z()) * static_cast<std::size_t>(count_.y()) +
            static_cast<std::size_t>(c.y())) *
               static_cast<std::size_t>(count_.x()) +
           static_cast<std::size_t>(c.x());
  };
  std::vector<int> order(found.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::size_t> cells;
  for (const auto& p : found) cells.push_back(number(p));
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return cells[a] < cells[b]; });
  start_.assign(static_cast<std::size_t>(count_.prod()) + 1, 0);
  for (const std::size_t c : cells) ++start_[c + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  for (const int k : order) places_.push_back(found[k]), corner_.push_back(corner[k]);
}

Eigen::Vector3i MoldPoints::cell(const Eigen::Vector3d& at) const {
  return ((at - low_) / size_)
      .cwiseMax(0.0)
      .cwiseMin((count_ - Eigen::Vector3i::Ones()).cast<double>())
      .cast<int>();
}

}  // namespace vacuform
