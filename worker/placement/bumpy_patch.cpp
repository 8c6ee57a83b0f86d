#include "worker/placement/bumpy_patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/flattening/methods.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/placement/bent_mesh.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/exact_geodesics.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The triangles around the centre with a corner within `reach_mm` in space, connected over edges; ascending.
std::vector<int> around(const InkedSurface& surface, const SheetPoint& centre, double reach_mm) {
  const Vector3d middle = surface.place(centre);
  std::vector<char> seen(surface.triangles().size(), 0);
  std::vector<int> out{centre.triangle};
  seen[index(centre.triangle)] = 1;
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int n = surface.across(out[i], k);
      if (n < 0 || seen[index(n)]) continue;
      seen[index(n)] = 1;
      const Triangle& c = surface.triangles()[index(n)];
      if (std::any_of(c.begin(), c.end(),
                      [&](int v) { return (surface.inked()[index(v)] - middle).norm() < reach_mm; }))
        out.push_back(n);
    }
  std::sort(out.begin(), out.end());
  return out;
}

// The neighbourhood; `flat` is its own flattening about the centre, as rigid as possible.
Result<BentMesh> flattened(const InkedSurface& surface, const SheetPoint& centre, double reach_mm,
                           const Context& context) {
  BentMesh out;
  out.faces = around(surface, centre, reach_mm);
  std::vector<int> local(surface.inked().size(), -1);
  for (const int t : out.faces) {
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const int v = surface.triangles()[index(t)][k];
      if (local[index(v)] < 0) {
        local[index(v)] = static_cast<int>(out.rest.size());
        out.rest.push_back(surface.rest()[index(v)]);
        out.inked.push_back(surface.inked()[index(v)]);
      }
      corners[k] = local[index(v)];
    }
    out.triangles.push_back(corners);
    out.corners.push_back({Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()});
  }
  Chart chart;
  chart.triangles = out.triangles, chart.inked = out.inked, chart.uv = out.rest;
  // Its progress does not count for the job.
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  VACUFORM_CHECK(flatten_arap(chart, Context()));
  out.flat = std::move(chart.uv);
  const auto middle = std::find(out.faces.begin(), out.faces.end(), centre.triangle) - out.faces.begin();
  const Vector2d origin = interpolate(out.triangles, {static_cast<int>(middle), centre.weights}, out.flat);
  for (Vector2d& p : out.flat) p -= origin;
  return out;
}

// The rotation of the chart relative to the directions of the geodesics near the centre, radians.
double turn_of(const BentMesh& near, const PolarGrid& grid) {
  const PlaneLocator locator(near.triangles, near.rest);
  Vector2d sum(0, 0);
  for (const auto& p : grid.passing())
    if (const auto at = locator.find(p.rest)) {
      const Vector2d d = interpolate(near.triangles, *at, near.flat);
      const double turn = std::atan2(d.y(), d.x()) - p.direction;
      sum += Vector2d(std::cos(turn), std::sin(turn));
    }
  return std::atan2(sum.y(), sum.x());
}

// Gives the vertices the shortest path from the centre over the surface as radius, and refines within `ink_mm`.
void measure(const InkedSurface& surface, BentMesh& near, const SheetPoint& centre, double reach_mm,
             double ink_mm) {
  constexpr double tolerance_mm = 0.02;
  Geodesics geodesics(surface.path_mesh());
  geodesics.begin_at(centre, reach_mm);
  const auto radius_at = [&](const SheetPoint& p) {
    const auto way = geodesics.to(p);
    return way ? way->length : std::numeric_limits<double>::infinity();
  };
  std::vector<char> asked(near.rest.size(), 0);
  for (std::size_t t = 0; t < near.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t v = index(near.triangles[t][k]);
      if (!asked[v]) near.radius[v] = radius_at({near.faces[t], near.corners[t][k]});
      asked[v] = 1;
    }
  refine(near, radius_at, ink_mm, tolerance_mm);
}

// Whether a large part of the flattening within `mm` lies off the chart.
bool leaves_chart(const ChartedSurface& charted, const BentMesh& near, double mm) {
  constexpr double good_part = 0.1;
  double off = 0, all = 0;
  for (std::size_t f = 0; f < near.faces.size(); ++f) {
    const Triangle& t = near.triangles[f];
    const auto uv = [&](std::size_t k) -> const Vector2d& { return near.flat[index(t[k])]; };
    if (uv(0).norm() > mm) continue;
    const double area = std::abs(cross(uv(1) - uv(0), uv(2) - uv(0)));
    all += area;
    if (!charted.on_chart(near.faces[f])) off += area;
  }
  return off > good_part * all;
}

// Share of a triangle's area on which a linear function with these corner values is below `level`.
double share_below(std::array<double, 3> f, double level) {
  std::sort(f.begin(), f.end());
  if (level <= f[0]) return 0;
  if (level >= f[2]) return 1;
  if (level <= f[1]) return (level - f[0]) * (level - f[0]) / ((f[1] - f[0]) * (f[2] - f[0]));
  return 1 - (f[2] - level) * (f[2] - level) / ((f[2] - f[1]) * (f[2] - f[0]));
}

// Radius of the circle in the plane with the area where `radius` is below each of 0, step, 2 step...
std::vector<double> flat_radii(const BentMesh& mesh, const std::vector<double>& radius, double step) {
  double most = 0;
  for (const double r : radius)
    if (std::isfinite(r)) most = std::max(most, r);
  std::vector<double> area(static_cast<std::size_t>(most / step) + 2, 0);
  for (const Triangle& t : mesh.triangles) {
    const std::array<double, 3> f{radius[index(t[0])], radius[index(t[1])], radius[index(t[2])]};
    if (!std::isfinite(f[0] + f[1] + f[2])) continue;
    const FlatTriangle flat =
        flat_triangle(mesh.inked[index(t[0])], mesh.inked[index(t[1])], mesh.inked[index(t[2])]);
    const double whole = 0.5 * flat.length * flat.height;
    const std::size_t from = static_cast<std::size_t>(*std::min_element(f.begin(), f.end()) / step);
    for (std::size_t j = from; j < area.size(); ++j) {
      const double share = share_below(f, static_cast<double>(j) * step);
      area[j] += share * whole;
    }
  }
  for (double& a : area) a = std::sqrt(a / M_PI);
  return area;
}

// Triangles that are turned over and have a corner within `ink_mm`.
int turned_over(const BentMesh& mesh, const std::vector<Vector2d>& uv, double ink_mm) {
  return static_cast<int>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    const Vector2d &a = uv[index(t[0])], &b = uv[index(t[1])], &c = uv[index(t[2])];
    return std::min({a.norm(), b.norm(), c.norm()}) < ink_mm && !(cross(b - a, c - a) > 0);
  }));
}

}  // namespace

Result<ElementPatch> bumpy_patch(const ChartedSurface& charted, const SheetPoint& centre,
                                 const Vector3d& axis, double ink_mm, CoilKeep keep, const Context& context) {
  constexpr double step_mm = 0.5, margin_mm = 3, near_mm = 10;
  const InkedSurface& surface = charted.surface();
  constexpr std::array<double, 4> shares{0, 0.2, 0.5, 1};  // of the local flattening in the radius
  const double reach = 1.15 * ink_mm + margin_mm;
  const PolarGrid grid(charted, centre, axis, std::min(near_mm, ink_mm), keep);
  VACUFORM_TRY(near, flattened(surface, centre, reach, context));
  const double turn = turn_of(near, grid);
  // Off the chart, on the folds at the foot of the mold, nothing is measured: the local flattening is good enough.
  const bool flattening_alone = leaves_chart(charted, near, ink_mm);
  near.radius.assign(near.rest.size(), 0);
  if (!flattening_alone) measure(surface, near, centre, 1.5 * reach, ink_mm);

  std::vector<Vector2d> best;
  int least = std::numeric_limits<int>::max();
  for (const double share : shares) {
    if (flattening_alone && share < 1) continue;
    std::vector<double> radius;
    for (std::size_t i = 0; i < near.radius.size(); ++i) {
      const double flattened_radius = near.flat[i].norm();
      radius.push_back(share == 1 ? flattened_radius
                                  : (1 - share) * near.radius[i] + share * flattened_radius);
    }
    const std::vector<double> flat =
        keep == CoilKeep::area ? flat_radii(near, radius, step_mm) : std::vector<double>();
    std::vector<Vector2d> uv;
    for (std::size_t i = 0; i < radius.size(); ++i) {
      const Vector2d& d = near.flat[i];
      const double ring = radius[i] / step_mm, angle = std::atan2(d.y(), d.x()) - turn;
      double r = std::numeric_limits<double>::infinity();
      if (keep == CoilKeep::diameter) {
        r = radius[i];
      } else if (std::isfinite(ring)) {
        const std::size_t j = std::min(static_cast<std::size_t>(ring), flat.size() - 2);
        r = flat[j] + (ring - static_cast<double>(j)) * (flat[j + 1] - flat[j]);
      }
      uv.push_back(r * Vector2d(std::cos(angle), std::sin(angle)));
    }
    const int over = turned_over(near, uv, ink_mm);
    if (over < least) least = over, best = std::move(uv);
    if (least == 0) break;
  }

  ElementPatch out;
  out.smooth = false;
  std::vector<int> local(near.rest.size(), -1);
  for (std::size_t f = 0; f < near.triangles.size(); ++f) {
    Triangle t = near.triangles[f];
    if (!std::all_of(t.begin(), t.end(), [&](int v) { return best[index(v)].allFinite(); })) continue;
    for (int& v : t) {
      int& to = local[index(v)];
      if (to < 0) {
        to = static_cast<int>(out.patch.uv.size());
        out.patch.uv.push_back(best[index(v)]);
        out.patch.rest.push_back(near.rest[index(v)]);
        out.patch.inked.push_back(near.inked[index(v)]);
      }
      v = to;
    }
    out.patch.triangles.push_back(t);
    out.on_chart.push_back(charted.on_chart(near.faces[f]));
  }
  return out;
}

}  // namespace vacuform
