#include "worker/flattening/region.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "worker/numerics/plane.hpp"

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

Spot spot_below(const FormedSheet& sheet, const std::vector<int>& region, const Eigen::Vector3d& top) {
  Spot best{-1, {}, false};
  double best_z = -std::numeric_limits<double>::infinity(), nearest = std::numeric_limits<double>::infinity();
  for (const int k : region) {
    const Triangle& t = sheet.triangles[k];
    const Eigen::Vector3d &a = sheet.formed[t[0]], &b = sheet.formed[t[1]], &c = sheet.formed[t[2]];
    const double whole = (b - a).cross(c - a).z();
    const Eigen::Vector3d w((b - top).cross(c - top).z(), (c - top).cross(a - top).z(),
                            (a - top).cross(b - top).z());
    if (whole > 0 && w.minCoeff() >= 0) {
      const double z = (w.x() * a.z() + w.y() * b.z() + w.z() * c.z()) / whole;
      if (z > best_z) best_z = z, best = {k, w / whole, true};
    }
    for (int e = 0; e < 3 && !best.exact; ++e)
      if (const double d = (sheet.formed[t[e]] - top).norm(); d < nearest)
        nearest = d, best = {k, Eigen::Vector3d::Unit(e), false};
  }
  return best;
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
