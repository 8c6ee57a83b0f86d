#include "worker/forming/point_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "worker/numerics/plane.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

// The share of a grid spacing by which the mold falls off a sharp edge within half a spacing. What is smoother is met by
// the vertices alone.
constexpr double sharp = 0.3;
// How far a point may stand above the sheet, mm: more than a smooth mold does between the corners of a triangle.
double tolerance(const Process& p) { return 0.02 * p.sheet.resolution_mm; }

using Corners = Eigen::Matrix3d;  // one a column

// How far a point lies above a triangle's plane, along the normal that counter-clockwise triangles show.
double height(const Corners& c, const Eigen::Vector3d& point) {
  const Eigen::Vector3d n = (c.col(1) - c.col(0)).cross(c.col(2) - c.col(0));
  const double length = n.norm();
  return length > 0 ? n.dot(point - c.col(0)) / length : -1;
}

// The weights of the corners at a point's foot on the triangle.
Eigen::Vector3d weights_at(const Corners& c, const Eigen::Vector3d& point) {
  const Eigen::Vector3d u = c.col(1) - c.col(0), v = c.col(2) - c.col(0), n = u.cross(v),
                        w = point - c.col(0);
  const double square = n.squaredNorm();
  const double second = w.cross(v).dot(n) / square, third = u.cross(w).dot(n) / square;
  return {1 - second - third, second, third};
}

double flat_area(const std::vector<Eigen::Vector2d>& rest, const Triangle& t) {
  const Eigen::Vector2d a = rest[t[1]] - rest[t[0]], b = rest[t[2]] - rest[t[0]];
  return 0.5 * cross(a, b);
}

}  // namespace

PointContact::PointContact(const Process& process)
    : points_(process.obstacles.mold(), process.sheet.resolution_mm, sharp * process.sheet.resolution_mm),
      caught_(points_.size(), 0),
      taken_(process.grid.rest.size(), 0),
      start_(process.grid.rest.size() + 1, 0),
      tolerance_mm_(tolerance(process)),
      apart_mm_(0.5 * process.sheet.resolution_mm),
      seen_mm_(0.35 * process.sheet.resolution_mm),
      least_area_(0.05 * process.sheet.resolution_mm * process.sheet.resolution_mm) {
  const auto& triangles = process.grid.triangles;
  for (const Triangle& t : triangles)
    for (const int v : t) ++start_[v + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  triangle_.resize(3 * triangles.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (const int v : triangles[k]) triangle_[next[v]++] = static_cast<int>(k);
}

std::optional<PointContact::Crossing> PointContact::crossing(const Process& process, const Points& x,
                                                             const Points& y, int triangle, int point) const {
  const Triangle& t = process.grid.triangles[triangle];
  const Eigen::Vector3d& p = points_.place(point);
  Corners from, way;
  from << x.col(t[0]), x.col(t[1]), x.col(t[2]);
  way << y.col(t[0]) - x.col(t[0]), y.col(t[1]) - x.col(t[1]), y.col(t[2]) - x.col(t[2]);
  const double before = height(from, p);
  if (before > seen_mm_ || height(from + way, p) <= tolerance_mm_) return std::nullopt;
  double below = 0, above = 1;
  if (before < 0)
    for (int i = 0; i < 30; ++i) {
      const double middle = (below + above) / 2;
      (height(from + middle * way, p) < 0 ? below : above) = middle;
    }
  constexpr double beside = -0.01;  // no point slips between two triangles
  Eigen::Vector3d weights = weights_at(from + below * way, p);
  if (!(weights.minCoeff() >= beside)) return std::nullopt;
  weights = weights.cwiseMax(0.0);
  return Crossing{below, triangle, point, weights / weights.sum()};
}

int PointContact::vertex_for(const Process& process, const SheetState& state, const Points& y,
                             const Crossing& crossing) const {
  const Triangle& t = process.grid.triangles[crossing.triangle];
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return crossing.weights[a] > crossing.weights[b]; });
  for (const int corner : order) {
    const int v = t[corner];
    constexpr double least_weight = 0.1;
    if (crossing.weights[corner] < least_weight) return -1;
    if (taken_[v] || state.contact[v] == Contact::clamp || state.contact[v] == Contact::platform) continue;
    std::vector<Eigen::Vector2d> rest(3);
    const Eigen::Vector2d moved = crossing.weights[0] * state.rest[t[0]] +
                                  crossing.weights[1] * state.rest[t[1]] +
                                  crossing.weights[2] * state.rest[t[2]];
    bool whole =
        true;  // every triangle around it keeps its sense, and some area on the flat sheet and on the mold
    for (int k = start_[v]; k < start_[v + 1] && whole; ++k) {
      const Triangle& around = process.grid.triangles[triangle_[k]];
      Corners solid;
      for (int c = 0; c < 3; ++c) {
        rest[c] = around[c] == v ? moved : state.rest[around[c]];
        solid.col(c) = around[c] == v ? points_.place(crossing.point) : Eigen::Vector3d(y.col(around[c]));
      }
      const double flat = flat_area(rest, {0, 1, 2});
      const double formed = 0.5 * (solid.col(1) - solid.col(0)).cross(solid.col(2) - solid.col(0)).norm();
      whole = flat > least_area_ && formed > 0.3 * flat;
    }
    if (whole) return v;
  }
  return -1;
}

bool PointContact::is_crowded(const Process& process, const Points& y, int vertex, int point) const {
  for (int k = start_[vertex]; k < start_[vertex + 1]; ++k)
    for (const int w : process.grid.triangles[triangle_[k]])
      if (w != vertex && taken_[w] && (points_.place(point) - y.col(w)).norm() < apart_mm_) return true;
  return false;
}

std::vector<int> PointContact::follow(const Process& process, SheetState& state, Points& y, double from_time,
                                      double to_time) {
  const auto& triangles = process.grid.triangles;
  std::vector<int> changed, look;
  if (points_.size() == 0) return changed;
  constexpr int parts = 64;
  const auto in_parts = [&](auto&& work) {
    in_parallel(0, parts, [&](int begin, int end) {
      for (int part = begin; part < end; ++part) work(part);
    });
  };
  std::vector<std::vector<int>> moved_by(parts);
  in_parts([&](int part) {
    for (std::size_t k = triangles.size() * part / parts; k < triangles.size() * (part + 1) / parts; ++k) {
      const Triangle& t = triangles[k];
      if (state.x.col(t[0]) != y.col(t[0]) || state.x.col(t[1]) != y.col(t[1]) ||
          state.x.col(t[2]) != y.col(t[2]))
        moved_by[part].push_back(static_cast<int>(k));
    }
  });
  for (const auto& some : moved_by) look.insert(look.end(), some.begin(), some.end());
  constexpr int most_rounds = 4;  // what a vertex that was taken lets through is looked at again
  for (int round = 0; round < most_rounds && !look.empty(); ++round) {
    std::vector<std::vector<Crossing>> found_by(parts);
    in_parts([&](int part) {
      for (std::size_t i = look.size() * part / parts; i < look.size() * (part + 1) / parts; ++i) {
        const int k = look[i];
        Eigen::Vector3d low = Eigen::Vector3d::Constant(HUGE_VAL), high = -low;
        for (const int v : triangles[k]) {
          low = low.cwiseMin(state.x.col(v)).cwiseMin(y.col(v));
          high = high.cwiseMax(state.x.col(v)).cwiseMax(y.col(v));
        }
        low.array() -= tolerance_mm_, high.array() += tolerance_mm_;
        points_.in_box(low, high, [&](int point) {
          const Eigen::Vector3d& p = points_.place(point);
          if (caught_[point] || (p.array() < low.array()).any() || (p.array() > high.array()).any()) return;
          if (const auto found = crossing(process, state.x, y, k, point)) found_by[part].push_back(*found);
        });
      }
    });
    std::vector<Crossing> crossings;
    for (const auto& some : found_by) crossings.insert(crossings.end(), some.begin(), some.end());
    std::sort(crossings.begin(), crossings.end(), [this](const Crossing& a, const Crossing& b) {
      const bool corner_a = points_.is_corner(a.point), corner_b = points_.is_corner(b.point);
      if (corner_a != corner_b) return corner_a;
      const double near_a = a.weights.maxCoeff(), near_b = b.weights.maxCoeff();
      return std::tie(near_b, a.time, a.point, a.triangle) < std::tie(near_a, b.time, b.point, b.triangle);
    });
    std::vector<int> dirty;
    // Of two vertices close together on an edge, neither reaches the far end of its triangles. Crowded ones come last.
    for (const bool crowded : {false, true})
      for (const Crossing& c : crossings) {
        if (caught_[c.point] || std::find(dirty.begin(), dirty.end(), c.triangle) != dirty.end()) continue;
        const int v = vertex_for(process, state, y, c);
        if (v < 0 || is_crowded(process, y, v, c.point) != crowded) continue;
        const Triangle& t = triangles[c.triangle];
        Eigen::Vector2d rest = Eigen::Vector2d::Zero();
        Eigen::Vector3d from = Eigen::Vector3d::Zero();
        for (int corner = 0; corner < 3; ++corner) {
          rest += c.weights[corner] * state.rest[t[corner]];
          from += c.weights[corner] * state.x.col(t[corner]);
        }
        state.rest[v] = rest;
        state.x.col(v) = from;
        y.col(v) = points_.place(c.point);
        state.held[v] = 1;
        state.folded[v] = 0;
        state.contact[v] = Contact::mold;
        if (!(state.time[v] >= 0)) state.time[v] = from_time + c.time * (to_time - from_time);
        caught_[c.point] = taken_[v] = 1;
        dirty.insert(dirty.end(), triangle_.begin() + start_[v], triangle_.begin() + start_[v + 1]);
      }
    std::sort(dirty.begin(), dirty.end());
    dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());
    changed.insert(changed.end(), dirty.begin(), dirty.end());
    look = std::move(dirty);
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  return changed;
}

}  // namespace vacuform
