#include "worker/placement/spacing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/numerics/dense.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A direction in the plane of the centre's triangle as (along the axis, across it).
Vector2d in_frame(const InkedSurface& surface, const Centre& c, const Vector3d& direction) {
  return {direction.dot(c.axis), direction.dot(surface.normal(c.point.triangle).cross(c.axis))};
}

// The way between two centres; where they coincide, the chart's u axis is its direction.
Connection way_between(const ChartedSurface& charted, const Centre& a, const Centre& b) {
  Connection way = connect(charted.surface(), a.point, b.point);
  if (way.leaving.isZero(0)) way.leaving = charted.axis(a.point.triangle);
  if (way.arriving.isZero(0)) way.arriving = charted.axis(b.point.triangle);
  return way;
}

// How much a centre counts for the place of the drawing's centre. Below 1e-6 of the largest it moves nothing.
std::vector<double> weights_about_origin(const std::vector<Centre>& centres) {
  std::vector<double> out;
  for (const Centre& c : centres) {
    const double square = 1 + c.drawn.squaredNorm();  // mm^2
    out.push_back(1 / (square * square));
  }
  const double largest = *std::max_element(out.begin(), out.end());
  for (double& w : out) w = w < 1e-6 * largest ? 0 : w;
  return out;
}

// Rows that shift the array as a whole, and how far it lies off its anchor; in units in which they outweigh distances.
struct Anchored {
  MatrixXd rows;
  double per_mm = 0;
};
Anchored anchored_rows(const std::vector<Centre>& centres) {
  constexpr double stiffness = 10;
  const std::vector<double> weights = weights_about_origin(centres);
  double sum = 0, squares = 0;
  for (const double w : weights) sum += w, squares += w * w;
  Anchored out{MatrixXd::Zero(2, 2 * static_cast<Eigen::Index>(centres.size())),
               stiffness * sum / std::sqrt(squares)};
  for (std::size_t i = 0; i < weights.size(); ++i)
    out.rows.middleCols<2>(2 * static_cast<Eigen::Index>(i)) =
        stiffness * weights[i] / std::sqrt(squares) * Eigen::Matrix2d::Identity();
  return out;
}

struct Measured {
  std::vector<Connection> ways;
  Vector2d off{0, 0};  // of the array from its anchor, mm
  double squares = 0;  // of the distances' errors, and of that
};

Measured measure(const ChartedSurface& charted, const std::vector<Centre>& centres,
                 const std::vector<Neighbours>& pairs, const std::optional<Anchor>& about, double per_mm) {
  Measured out;
  if (about) {
    out.off = off_origin(charted.surface(), about->origin, centres) - about->off;
    out.squares = (per_mm * out.off).squaredNorm();
  }
  for (const Neighbours& n : pairs) {
    out.ways.push_back(way_between(charted, centres[index(n.a)], centres[index(n.b)]));
    const double error = out.ways.back().mm - n.drawn_mm;
    out.squares += n.weight * error * error;
  }
  return out;
}

// Rows that preserve the array's mean place and mean turn, as unit vectors over all moves.
MatrixXd rigid_rows(const std::vector<Centre>& centres) {
  const Eigen::Index n = static_cast<Eigen::Index>(centres.size());
  MatrixXd rows = MatrixXd::Zero(3, 2 * n);
  Vector2d middle = Vector2d::Zero();
  for (const Centre& c : centres) middle += c.drawn / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector2d arm = centres[i].drawn - middle;
    rows(0, 2 * i) = rows(1, 2 * i + 1) = 1;
    rows(2, 2 * i) = -arm.y();
    rows(2, 2 * i + 1) = arm.x();
  }
  for (Eigen::Index r = 0; r < 3; ++r)
    if (const double norm = rows.row(r).norm(); norm > 0) rows.row(r) /= norm;
  return rows;
}

}  // namespace

void move(const InkedSurface& surface, Centre& centre, const Vector2d& by) {
  const double way = by.norm();
  if (way == 0) return;
  const int t = centre.point.triangle;
  const Vector3d direction = by.x() * centre.axis + by.y() * surface.normal(t).cross(centre.axis);
  GeodesicWalk walk(surface, centre.point, direction);
  const double back = angle_between(surface, t, direction, centre.axis);
  const double walked = walk.advance(way);
  centre.point = walk.at();
  centre.axis = turned(surface, centre.point.triangle, walk.along(), back);
  centre.moved += walked / way * by;
}

Vector2d off_origin(const InkedSurface& surface, const Centre& origin, const std::vector<Centre>& centres) {
  const std::vector<double> weights = weights_about_origin(centres);
  Vector2d sum = Vector2d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (weights[i] == 0) continue;
    const Connection way = connect(surface, origin.point, centres[i].point);
    sum += weights[i] * (way.mm * in_frame(surface, origin, way.leaving) - centres[i].drawn);
    total += weights[i];
  }
  return sum / total;
}

std::vector<Neighbours> neighbours(const std::vector<Centre>& centres, const std::vector<int>& nodes) {
  constexpr double near = 1.25,
                   slack = 1.02;  // of the radii together; of the circle, so that squares have no diagonals
  const auto drawn = [&](int i) -> const Vector2d& { return centres[index(i)].drawn; };
  std::vector<Neighbours> out;
  for (const int a : nodes) {
    std::vector<int> others = nodes;  // nearest first: what lies in a circle is found soon
    std::sort(others.begin(), others.end(), [&](int p, int q) {
      return std::pair((drawn(p) - drawn(a)).squaredNorm(), p) <
             std::pair((drawn(q) - drawn(a)).squaredNorm(), q);
    });
    for (const int b : others) {
      if (b <= a) continue;
      const double mm = (drawn(a) - drawn(b)).norm();
      const Vector2d middle = (drawn(a) + drawn(b)) / 2;
      const bool free = std::none_of(others.begin(), others.end(), [&](int c) {
        return c != a && c != b && (drawn(c) - middle).norm() < slack * mm / 2 &&
               (drawn(c) - drawn(a)).norm() < mm && (drawn(c) - drawn(b)).norm() < mm;
      });
      if (!free) continue;
      const double reach = near * (centres[index(a)].radius_mm + centres[index(b)].radius_mm);
      out.push_back({a, b, mm, mm > reach ? reach * reach / (mm * mm) : 1});
    }
  }
  std::sort(out.begin(), out.end(), [](const Neighbours& p, const Neighbours& q) {
    return std::pair(p.a, p.b) < std::pair(q.a, q.b);
  });
  return out;
}

Result<void> multilaterate(const ChartedSurface& charted, std::vector<Centre>& centres,
                           const std::vector<Neighbours>& pairs, const Context& context,
                           const std::optional<Anchor>& about) {
  if (pairs.empty()) return {};
  constexpr int most_iterations = 40;
  constexpr double held = 1e-2;  // weight that keeps what no pair determines; too small to affect a distance
  const Eigen::Index size = 2 * static_cast<Eigen::Index>(centres.size());
  const InkedSurface& surface = charted.surface();
  const bool any_fixed = std::any_of(centres.begin(), centres.end(), [](const Centre& c) { return c.fixed; });
  MatrixXd rigid = rigid_rows(centres);
  if (any_fixed) rigid.setZero();
  Anchored anchored;
  if (about) {
    anchored = anchored_rows(centres);
    rigid.topRows<2>().setZero();
  }
  Measured now = measure(charted, centres, pairs, about, anchored.per_mm);
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    MatrixXd normal = held * held * MatrixXd::Identity(size, size) + rigid.transpose() * rigid;
    VectorXd moved(size);
    for (Eigen::Index i = 0; i < size / 2; ++i) moved.segment<2>(2 * i) = centres[i].moved;
    VectorXd rhs = -(held * held * moved + rigid.transpose() * (rigid * moved));
    if (about) {
      normal += anchored.rows.transpose() * anchored.rows;
      rhs -= anchored.rows.transpose() * (anchored.per_mm * now.off);
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const int a = pairs[p].a, b = pairs[p].b;
      const Vector2d at_a = -in_frame(surface, centres[index(a)], now.ways[p].leaving),
                     at_b = in_frame(surface, centres[index(b)], now.ways[p].arriving);
      const double weight = pairs[p].weight, error = weight * (now.ways[p].mm - pairs[p].drawn_mm);
      normal.block<2, 2>(2 * a, 2 * a) += weight * at_a * at_a.transpose();
      normal.block<2, 2>(2 * b, 2 * b) += weight * at_b * at_b.transpose();
      normal.block<2, 2>(2 * a, 2 * b) += weight * at_a * at_b.transpose();
      normal.block<2, 2>(2 * b, 2 * a) += weight * at_b * at_a.transpose();
      rhs.segment<2>(2 * a) -= error * at_a;
      rhs.segment<2>(2 * b) -= error * at_b;
    }
    for (Eigen::Index i = 0; i < size; ++i) {
      if (!centres[index(static_cast<int>(i / 2))].fixed) continue;
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1, rhs[i] = 0;
    }
    VectorXd step = solve_symmetric(normal, rhs);
    constexpr double longest_mm = 10;
    if (const double longest = step.cwiseAbs().maxCoeff(); longest > longest_mm) step *= longest_mm / longest;
    std::vector<Centre> before = centres;
    Measured next;
    for (int halving = 0; halving < 8; ++halving, step *= 0.5) {
      centres = before;
      for (Eigen::Index i = 0; i < size / 2; ++i) move(surface, centres[i], step.segment<2>(2 * i));
      next = measure(charted, centres, pairs, about, anchored.per_mm);
      if (next.squares <= now.squares * (1 + 1e-9) + 1e-9 * static_cast<double>(pairs.size())) break;
    }
    now = std::move(next);
    if (step.cwiseAbs().maxCoeff() < 1e-3) break;
  }
  return {};
}

std::vector<double> turns(const ChartedSurface& charted, const std::vector<Centre>& centres,
                          const std::vector<Neighbours>& pairs) {
  std::vector<Vector2d> sum(centres.size(), Vector2d::Zero());  // of unit vectors at the turns wanted
  const auto add = [&](int from, int to, const Vector3d& direction) {
    const Vector2d there = in_frame(charted.surface(), centres[index(from)], direction);
    const Vector2d drawn = centres[index(to)].drawn - centres[index(from)].drawn;
    const double turn = std::atan2(there.y(), there.x()) - std::atan2(drawn.y(), drawn.x());
    sum[index(from)] += Vector2d(std::cos(turn), std::sin(turn));
  };
  for (const Neighbours& n : pairs) {
    const Connection way = way_between(charted, centres[index(n.a)], centres[index(n.b)]);
    add(n.a, n.b, way.leaving);
    add(n.b, n.a, -way.arriving);
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < sum.size(); ++i)
    out.push_back(sum[i].norm() > 1e-9 && !centres[i].fixed ? std::atan2(sum[i].y(), sum[i].x()) : 0);
  return out;
}

}  // namespace vacuform
