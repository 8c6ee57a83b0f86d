#include "worker/scan/placing.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/min_quadrilateral_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "worker/numerics/plane.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

using Points = std::vector<Eigen::Vector2d>;

bool holds(const Circle& circle, const Points& points, double slack) {
  return std::all_of(points.begin(), points.end(), [&](const Eigen::Vector2d& p) {
    return (p - circle.centre).norm() <= circle.radius + slack;
  });
}

// The smallest circle around at most four points. Keeps only its support, the two or three points that define it.
Circle around_few(Points& points, double slack) {
  Circle best{points.front(), HUGE_VAL};
  Points support;
  const auto offer = [&](const Circle& circle, Points on_it) {
    if (!(circle.radius < best.radius) || !holds(circle, points, slack)) return;
    best = circle;
    support = std::move(on_it);
  };
  if (points.size() == 1) return {points.front(), 0};
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const auto &a = points[i], &b = points[j];
      offer({(a + b) / 2, (b - a).norm() / 2}, {a, b});
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const Eigen::Vector2d u = b - a, v = points[k] - a;
        const double twice = cross(u, v);
        if (twice == 0) continue;
        const double uu = u.squaredNorm(), vv = v.squaredNorm();
        const Eigen::Vector2d to(v.y() * uu - u.y() * vv, u.x() * vv - v.x() * uu);
        const Eigen::Vector2d centre = a + to / (2 * twice);
        offer({centre, (a - centre).norm()}, {a, b, points[k]});
      }
    }
  if (!support.empty()) points = std::move(support);
  return best;
}

}  // namespace

double longest_side(const TriangleMesh& upright) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const Box box = bounds(upright);
  std::vector<Kernel::Point_2> points, hull, rectangle;
  for (const auto& p : upright.vertices) points.emplace_back(p.x(), p.y());
  CGAL::convex_hull_2(points.begin(), points.end(), std::back_inserter(hull));
  if (hull.size() < 3) return box.size().maxCoeff();
  CGAL::min_rectangle_2(hull.begin(), hull.end(), std::back_inserter(rectangle));
  const double side = CGAL::squared_distance(rectangle[0], rectangle[1]),
               other = CGAL::squared_distance(rectangle[1], rectangle[2]);
  return std::max(std::sqrt(std::max(side, other)), box.size().z());
}

Circle enclosing_circle(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  constexpr int most_rounds = 1000;  // a few dozen at most; rounding must not keep it going
  const double slack = 1e-12 * bounds(mesh).size().head<2>().norm();
  Points support{mesh.vertices.front().head<2>()};
  Circle circle{support.front(), 0};
  for (int round = 0; round < most_rounds; ++round) {
    Eigen::Vector2d farthest = circle.centre;
    double most = 0;
    for (const auto& p : mesh.vertices)
      if (const double squared = (p.head<2>() - circle.centre).squaredNorm(); squared > most)
        most = squared, farthest = p.head<2>();
    if (std::sqrt(most) <= circle.radius + slack) break;
    support.push_back(farthest);
    const Circle wider = around_few(support, slack);
    if (!std::isfinite(wider.radius) || wider.radius <= circle.radius) break;
    circle = wider;
  }
  return circle;
}

Eigen::Matrix3d turn_about_z(double radians) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(radians).toRotationMatrix();
  return turn;
}

Eigen::Matrix3d principal_turn(const TriangleMesh& mesh) {
  double total = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  const auto corner = [&](int v) -> Eigen::Vector2d { return mesh.vertices[v].head<2>(); };
  for (const Triangle& t : mesh.triangles) {
    const double area = area_vector(mesh, t).norm();
    total += area;
    middle += area / 3 * (corner(t[0]) + corner(t[1]) + corner(t[2]));
  }
  if (!(total > 0)) return Eigen::Matrix3d::Identity();
  middle /= total;

  // Exact integrals of the squares over each triangle.
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Triangle& t : mesh.triangles) {
    const double area = area_vector(mesh, t).norm();
    const Eigen::Vector2d a = corner(t[0]) - middle, b = corner(t[1]) - middle, c = corner(t[2]) - middle;
    const Eigen::Vector2d sum = a + b + c;
    spread += area / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  double angle = std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1)) / 2;

  // The same for the third power of the coordinate along the longer axis: ten times its integral over the area is the
  // sum of all products of three corners.
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  double skew = 0;
  for (const Triangle& t : mesh.triangles) {
    const double a = along.dot(corner(t[0]) - middle), b = along.dot(corner(t[1]) - middle),
                 c = along.dot(corner(t[2]) - middle);
    skew += area_vector(mesh, t).norm() * (a * a * a + b * b * b + c * c * c + a * a * (b + c) +
                                           b * b * (a + c) + c * c * (a + b) + a * b * c);
  }
  if (skew < 0) angle += std::numbers::pi;
  return turn_about_z(-angle);
}

}  // namespace vacuform
