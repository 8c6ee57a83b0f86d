#include "worker/forming/spring_net.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

constexpr double isotropic = 0.75;
constexpr double dashpot_ratio = 0.1;  // damping of the highest frequency by dashpots, over critical
constexpr double shortest = 1e-6;      // mm: a spring that is crushed further has no direction

// An edge of the triangulation with its two sides: the opposite vertex and the stiff area of the triangle, or -1 and 0.
struct Edge {
  int a, b;  // a < b
  int left = -1, right = -1;
  double area = 0;
};

std::vector<Edge> edges_of(const std::vector<Triangle>& triangles, const std::vector<double>& area) {
  std::vector<Edge> sides;
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int e = 0; e < 3; ++e) {
      const int a = triangles[k][e], b = triangles[k][(e + 1) % 3], c = triangles[k][(e + 2) % 3];
      sides.push_back(a < b ? Edge{a, b, c, -1, area[k]} : Edge{b, a, -1, c, area[k]});
    }
  std::sort(sides.begin(), sides.end(), [](const Edge& s, const Edge& t) {
    return std::tuple(s.a, s.b, s.left) < std::tuple(t.a, t.b, t.left);
  });
  std::vector<Edge> edges;
  for (const Edge& side : sides)
    if (!edges.empty() && edges.back().a == side.a && edges.back().b == side.b) {
      Edge& edge = edges.back();
      edge.left = std::max(edge.left, side.left);
      edge.right = std::max(edge.right, side.right);
      edge.area += side.area;
    } else {
      edges.push_back(side);
    }
  return edges;
}

// Whether the edge is the longest of both adjacent triangles: the diagonal of a cell.
bool is_diagonal(const Edge& edge, const std::vector<Eigen::Vector2d>& rest) {
  const double own = (rest[edge.a] - rest[edge.b]).squaredNorm();
  const auto shorter = [&](int v) {
    return v >= 0 && (rest[edge.a] - rest[v]).squaredNorm() < own &&
           (rest[edge.b] - rest[v]).squaredNorm() < own;
  };
  return shorter(edge.left) && shorter(edge.right);
}

// A line of the grid, from the vertex that stores it.
struct Line {
  int to;
  double area;
};

// From each neighbour of each vertex, across the vertex, straight on to another neighbour.
std::vector<BendingSpring> bending_springs_of(const std::vector<std::vector<Line>>& lines,
                                              const std::vector<Eigen::Vector2d>& rest,
                                              double plate_stiffness) {
  constexpr double straight = -0.9;  // cosine between the two directions from the middle
  std::vector<BendingSpring> springs;
  for (std::size_t middle = 0; middle < lines.size(); ++middle)
    for (std::size_t i = 0; i < lines[middle].size(); ++i)
      for (std::size_t j = i + 1; j < lines[middle].size(); ++j) {
        const Line &one = lines[middle][i], &other = lines[middle][j];
        const Eigen::Vector2d to = rest[one.to] - rest[middle], from = rest[middle] - rest[other.to];
        if (-to.dot(from) > straight * to.norm() * from.norm()) continue;
        // Curvature is the sum of the ends minus twice the middle, over the square of the spacing.
        const double spacing = 0.5 * (to + from).norm();
        springs.push_back({one.to, static_cast<int>(middle), other.to,
                           plate_stiffness * 0.5 * (one.area + other.area) / std::pow(spacing, 4)});
      }
  return springs;
}

}  // namespace

SpringNet::SpringNet(const SheetGrid& grid, const std::vector<double>& stiffness, double thickness_mm,
                     const Material& material)
    : triangles_(grid.triangles),
      mass_(grid.rest.size(), 0),
      in_sheet_(grid.rest.size()),
      moving_(static_cast<int>(grid.rest.size())) {
  const auto& rest = grid.rest;
  for (int v = 0; v < moving_; ++v) in_sheet_[v] = v;
  std::vector<double> stiff_area;
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    const Triangle& t = triangles_[k];
    const Eigen::Vector2d b = rest[t[1]] - rest[t[0]], c = rest[t[2]] - rest[t[0]];
    const double area = 0.5 * cross(b, c);
    stiff_area.push_back(stiffness[k] * area);
    for (int v : t) mass_[v] += material.density * thickness_mm * area / 3;
  }

  const double membrane_stiffness = material.young * thickness_mm;
  std::vector<std::vector<Line>> lines(rest.size());
  const auto add = [&](int a, int b, int left, int right, double area) {
    const double squared = (rest[a] - rest[b]).squaredNorm();
    springs_.push_back(
        {a, b, left, right, std::sqrt(squared), isotropic * membrane_stiffness * area / squared});
  };
  for (const Edge& e : edges_of(triangles_, stiff_area)) {
    add(e.a, e.b, e.left, e.right, e.area);
    if (is_diagonal(e, rest)) {
      add(std::min(e.left, e.right), std::max(e.left, e.right), -1, -1, e.area);
    } else {
      lines[e.a].push_back({e.b, e.area});
      lines[e.b].push_back({e.a, e.area});
    }
  }
  // In the order of the vertices, for cache locality.
  std::stable_sort(springs_.begin(), springs_.end(), [](const Spring& s, const Spring& t) {
    return std::pair(s.a, s.b) < std::pair(t.a, t.b);
  });
  bending_springs_ = bending_springs_of(lines, rest, membrane_stiffness * thickness_mm * thickness_mm / 9);

  Points flat = Points::Zero(3, moving_);
  for (int v = 0; v < moving_; ++v) flat.col(v).head<2>() = rest[v];
  dashpot_ms_ = 2 * dashpot_ratio / Jacobian(*this, flat, 0).highest_frequency();
}

SpringNet SpringNet::part(const std::vector<char>& held) const {
  SpringNet part;
  part.dashpot_ms_ = dashpot_ms_;
  std::vector<int> number(mass_.size(), -1);
  const auto take = [&](int v) {
    if (number[v] >= 0) return;
    number[v] = part.vertices();
    part.in_sheet_.push_back(v);
    part.mass_.push_back(mass_[v]);
  };
  for (int v = 0; v < vertices(); ++v)
    if (!held[v]) take(v);
  part.moving_ = part.vertices();
  const auto moves = [&](std::initializer_list<int> all) {
    return std::any_of(all.begin(), all.end(), [&](int v) { return !held[v]; });
  };
  for (const Triangle& t : triangles_)
    if (moves({t[0], t[1], t[2]})) {
      for (int v : t) take(v);
      part.triangles_.push_back({number[t[0]], number[t[1]], number[t[2]]});
    }
  for (const Spring& s : springs_)
    if (moves({s.a, s.b})) {
      take(s.a), take(s.b);
      const auto beside = [&](int v) { return v < 0 ? -1 : number[v]; };
      part.springs_.push_back(
          {number[s.a], number[s.b], beside(s.left), beside(s.right), s.rest, s.stiffness});
    }
  for (const BendingSpring& s : bending_springs_)
    if (moves({s.a, s.middle, s.b})) {
      take(s.a), take(s.middle), take(s.b);
      part.bending_springs_.push_back({number[s.a], number[s.middle], number[s.b], s.stiffness});
    }
  return part;
}

void SpringNet::forces(const Points& x, const Points& v, double p, double gravity, Points& f) const {
  f.setZero(3, vertices());
  for (int i = 0; i < moving_; ++i) f(2, i) = -gravity * mass_[i];
  for (const Spring& s : springs_) {
    const Eigen::Vector3d d = x.col(s.b) - x.col(s.a), w = v.col(s.b) - v.col(s.a);
    const double over = 1 / std::max(shortest, d.norm());
    const Eigen::Vector3d pull = s.stiffness * (1 - s.rest * over + dashpot_ms_ * d.dot(w) * over * over) * d;
    f.col(s.a) += pull;
    f.col(s.b) -= pull;
  }
  for (const BendingSpring& s : bending_springs_) {
    const Eigen::Vector3d pull = s.stiffness * (x.col(s.a) - 2 * x.col(s.middle) + x.col(s.b));
    f.col(s.a) -= pull;
    f.col(s.middle) += 2 * pull;
    f.col(s.b) -= pull;
  }
  if (p == 0) return;
  for (const Triangle& t : triangles_) {
    const Eigen::Vector3d a = x.col(t[0]), b = x.col(t[1]) - a, c = x.col(t[2]) - a;
    const Eigen::Vector3d push = (p / 6) * b.cross(c);
    for (int i : t) f.col(i) -= push;
  }
}

SpringNet::Jacobian::Jacobian(const SpringNet& net, const Points& x, double p) : net_(net) {
  links_.reserve(net.springs_.size());
  for (const Spring& s : net.springs_) {
    const Eigen::Vector3d d = x.col(s.b) - x.col(s.a);
    const double over = 1 / std::max(shortest, d.norm());
    links_.push_back({over * d, s.stiffness, s.stiffness * (1 - s.rest * over)});
    // The pressure on a is -p/6 times the sum of b x c over the triangles (a, b, c) around it, as they close.
    if (p != 0 && s.left >= 0 && s.right >= 0)
      turns_.push_back({s.a, s.b, (p / 6) * (x.col(s.left) - x.col(s.right))});
  }
}

void SpringNet::Jacobian::multiply(const Points& d, double by_place, double by_velocity, Points& out) const {
  out.setZero(3, net_.vertices());
  const double along = by_place + by_velocity * net_.dashpot_ms_;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Spring& s = net_.springs_[k];
    const Link& l = links_[k];
    const Eigen::Vector3d w = d.col(s.b) - d.col(s.a);
    const double across = by_place * l.across;
    const Eigen::Vector3d pull = across * w + ((along * l.stiffness - across) * l.along.dot(w)) * l.along;
    out.col(s.a) += pull;
    out.col(s.b) -= pull;
  }
  for (const Turn& t : turns_) {
    const Eigen::Vector3d da = d.col(t.a), db = d.col(t.b), axis = by_place * t.axis;
    out.col(t.a) += axis.cross(db);
    out.col(t.b) -= axis.cross(da);
  }
  for (const BendingSpring& s : net_.bending_springs_) {
    const Eigen::Vector3d pull = (by_place * s.stiffness) * (d.col(s.a) - 2 * d.col(s.middle) + d.col(s.b));
    out.col(s.a) -= pull;
    out.col(s.middle) += 2 * pull;
    out.col(s.b) -= pull;
  }
}

std::vector<Eigen::Matrix3d> SpringNet::Jacobian::diagonal(double by_place, double by_velocity) const {
  std::vector<Eigen::Matrix3d> blocks(net_.vertices(), Eigen::Matrix3d::Zero());
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const double along = by_place + by_velocity * net_.dashpot_ms_;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& l = links_[k];
    const double across = by_place * std::max(0.0, l.across);
    const Eigen::Matrix3d block = across * I + (along * l.stiffness - across) * l.along * l.along.transpose();
    blocks[net_.springs_[k].a] -= block;
    blocks[net_.springs_[k].b] -= block;
  }
  for (const BendingSpring& s : net_.bending_springs_) {
    blocks[s.a] -= by_place * s.stiffness * I;
    blocks[s.middle] -= 4 * by_place * s.stiffness * I;
    blocks[s.b] -= by_place * s.stiffness * I;
  }
  blocks.resize(net_.moving_);
  return blocks;
}

double SpringNet::Jacobian::highest_frequency() const {
  std::vector<double> row(net_.vertices(), 0);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Spring& s = net_.springs_[k];
    const double bound = 2 * std::max(links_[k].stiffness, links_[k].across);
    row[s.a] += bound, row[s.b] += bound;
  }
  for (const Turn& t : turns_) row[t.a] += t.axis.norm(), row[t.b] += t.axis.norm();
  for (const BendingSpring& s : net_.bending_springs_)
    row[s.a] += 4 * s.stiffness, row[s.middle] += 8 * s.stiffness, row[s.b] += 4 * s.stiffness;
  double highest = 0;
  for (int i = 0; i < net_.moving_; ++i) highest = std::max(highest, row[i] / net_.mass_[i]);
  return std::sqrt(highest);
}

}  // namespace vacuform
