#include "worker/flattening/region.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/numerics/plane.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {

namespace {

double area(const FormedSheet& sheet, int k) {
  const Triangle& t = sheet.triangles[k];
  return 0.5 *
         (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]).norm();
}

// Connected parts, across edges, of the triangles with inside[k] == wanted: a part number per triangle, otherwise -1.
std::vector<int> parts(const InkedSurface& surface, const std::vector<char>& inside, char wanted,
                       int& count) {
  std::vector<int> part(inside.size(), -1), stack;
  count = 0;
  for (int seed = 0; seed < static_cast<int>(inside.size()); ++seed) {
    if (inside[seed] != wanted || part[seed] >= 0) continue;
    stack.assign(1, seed);
    part[seed] = count;
    while (!stack.empty()) {
      const int k = stack.back();
      stack.pop_back();
      for (int e = 0; e < 3; ++e)
        if (const int n = surface.across(k, e); n >= 0 && inside[n] == wanted && part[n] < 0)
          part[n] = count, stack.push_back(n);
    }
    ++count;
  }
  return part;
}

constexpr double on_vertical_mm = 1e-6;

// The point of a triangle nearest to a vertical line; of equally near ones the highest.
struct Passed {
  Eigen::Vector3d corners{1, 0, 0};  // weights
  double off_mm = std::numeric_limits<double>::infinity(), z = 0;
};
Passed nearest_to_vertical(const std::array<Eigen::Vector3d, 3>& p, const Eigen::Vector2d& at) {
  // A share of the squared longest side: below it the triangle is seen edge-on, and only its sides count.
  constexpr double edge_on = 1e-9;
  const auto flat = [&](std::size_t k) -> Eigen::Vector2d { return p[k].head<2>() - at; };
  const Eigen::Vector3d w(cross(flat(1), flat(2)), cross(flat(2), flat(0)), cross(flat(0), flat(1)));
  const double longest =
      std::max({(p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()});
  Passed best;
  const auto offer = [&](const Eigen::Vector3d& corners, double off_mm) {
    const double z = corners[0] * p[0].z() + corners[1] * p[1].z() + corners[2] * p[2].z();
    const bool as_near = std::abs(off_mm - best.off_mm) <= on_vertical_mm;
    if (as_near ? z > best.z : off_mm < best.off_mm) best = {corners, off_mm, z};
  };
  if (w.sum() > edge_on * longest && w.minCoeff() >= 0) {
    offer(w / w.sum(), 0);
    return best;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t n = (k + 1) % 3;
    const double f = nearest_on_edge<Eigen::Vector2d>({0, 0}, flat(k), flat(n));
    for (const double share : {f, 0.0, 1.0}) {  // the ends too: a vertical edge is a point from above
      Eigen::Vector3d corners = Eigen::Vector3d::Zero();
      corners[static_cast<Eigen::Index>(k)] = 1 - share;
      corners[static_cast<Eigen::Index>(n)] = share;
      offer(corners, ((1 - share) * flat(k) + share * flat(n)).norm());
    }
  }
  return best;
}

}  // namespace

std::vector<int> region_of_interest(const FormedSheet& sheet, const InkedSurface& surface) {
  std::vector<char> inside;
  for (const Triangle& t : sheet.triangles)
    inside.push_back(
        std::all_of(t.begin(), t.end(), [&](int v) { return sheet.contact[v] == Contact::mold; }));

  int count = 0;
  const auto part = parts(surface, inside, 1, count);
  std::vector<double> size(count, 0);
  for (std::size_t k = 0; k < part.size(); ++k)
    if (part[k] >= 0) size[part[k]] += area(sheet, static_cast<int>(k));
  const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  for (std::size_t k = 0; k < part.size(); ++k) inside[k] = count > 0 && part[k] == largest;

  // A part that does not reach the border of the sheet without crossing the region is a hole of the region.
  const auto rest = parts(surface, inside, 0, count);
  std::vector<char> reaches_border(count, 0);
  for (std::size_t k = 0; k < rest.size(); ++k)
    for (int e = 0; e < 3 && rest[k] >= 0; ++e)
      if (surface.across(static_cast<int>(k), e) < 0) reaches_border[rest[k]] = 1;
  std::vector<int> region;
  for (std::size_t k = 0; k < rest.size(); ++k)
    if (inside[k] || (rest[k] >= 0 && !reaches_border[rest[k]])) region.push_back(static_cast<int>(k));
  return region;
}

Spot spot_below(const InkedSurface& surface, const std::vector<int>& region, const Eigen::Vector3d& top) {
  constexpr double level_mm = 1e-9;
  Spot best{-1, {}, true};
  double best_z = -std::numeric_limits<double>::infinity();
  for (const int k : region) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t e = 0; e < 3; ++e) p[e] = surface.inked()[index(surface.triangles()[index(k)][e])];
    const Passed passed = nearest_to_vertical(p, top.head<2>());
    if (passed.off_mm <= on_vertical_mm && passed.z > best_z + level_mm)
      best_z = passed.z, best = {k, passed.corners, true};
  }
  if (best.triangle >= 0) return best;
  const SheetPoint nearest = nearest_point(surface.triangles(), surface.inked(), region, top).point;
  return {nearest.triangle, nearest.weights, false};
}

Spot spot_at_rest(const FormedSheet& sheet, const std::vector<int>& region, const Eigen::Vector2d& st) {
  for (const int k : region) {
    const Triangle& t = sheet.triangles[k];
    const Eigen::Vector2d &a = sheet.rest[t[0]], &b = sheet.rest[t[1]], &c = sheet.rest[t[2]];
    const double whole = cross(b - a, c - a);
    const Eigen::Vector3d w(cross(b - st, c - st), cross(c - st, a - st), cross(a - st, b - st));
    if (whole > 0 && w.minCoeff() >= -1e-9 * whole) return {k, w / whole, true};
  }
  return {};
}

}  // namespace vacuform
