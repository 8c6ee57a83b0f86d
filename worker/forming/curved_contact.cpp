#include "worker/forming/curved_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/numerics/plane.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/adjacency.hpp"
#include "worker/surface/split_triangle.hpp"

namespace vacuform {

namespace {

constexpr double least_mm = 0.02, most_of_edge = 0.05, most_of_height = 0.1;
constexpr double least_smooth = 0.99;  // length of the mean of the normals around a vertex

using Gradient = Eigen::Matrix<double, 2, 3>;

// How the place on the flat sheet changes along the formed one, at each vertex: the mean of the triangles around it. Not a
// number where one of them does not lie on the mold, or where the mold has an edge.
std::vector<Gradient> rest_gradients(const FormedSheet& sheet) {
  struct Around {
    Gradient gradient = Gradient::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double area = 0;
    bool on_mold = true;
  };
  std::vector<Around> around(sheet.rest.size());
  for (const Triangle& t : sheet.triangles) {
    Eigen::Matrix2d flat;
    flat << sheet.rest[t[1]] - sheet.rest[t[0]], sheet.rest[t[2]] - sheet.rest[t[0]];
    Eigen::Matrix<double, 3, 2> solid;
    solid << sheet.formed[t[1]] - sheet.formed[t[0]], sheet.formed[t[2]] - sheet.formed[t[0]];
    const Gradient gradient = flat * (solid.transpose() * solid).inverse() * solid.transpose();
    const Eigen::Vector3d normal = solid.col(0).cross(solid.col(1)) / 2;
    const double area = normal.norm();
    const bool on_mold = std::ranges::all_of(t, [&](int v) { return sheet.contact[v] == Contact::mold; });
    for (const int v : t) {
      around[v].gradient += area * gradient;
      around[v].normal += normal;
      around[v].area += area;
      around[v].on_mold = around[v].on_mold && on_mold;
    }
  }
  std::vector<Gradient> out;
  for (const Around& a : around) {
    const bool smooth = a.normal.norm() >= least_smooth * a.area;
    out.emplace_back(a.on_mold && smooth ? Gradient(a.gradient / a.area) : Gradient::Constant(NAN));
  }
  return out;
}

}  // namespace

void bend_to_mold(FormedSheet& sheet, const Obstacles& obstacles, const TemperatureField& temperature) {
  const std::vector<int> opposite = opposite_sides(sheet.triangles);
  const auto corner = [&](int side, int k) { return sheet.triangles[side / 3][(side % 3 + k) % 3]; };
  const auto area_vector = [&](int side) -> Eigen::Vector3d {
    const Eigen::Vector3d &a = sheet.formed[corner(side, 0)], &b = sheet.formed[corner(side, 1)],
                          &c = sheet.formed[corner(side, 2)];
    return (b - a).cross(c - a);
  };
  // Where the new vertex of an edge lies, found at the second of its sides.
  const auto bend = [&](int side) -> std::optional<Eigen::Vector3d> {
    const int a = corner(side, 1), b = corner(side, 2);
    if (opposite[side] < 0 || opposite[side] > side || sheet.contact[a] != Contact::mold ||
        sheet.contact[b] != Contact::mold)
      return std::nullopt;
    const Eigen::Vector3d middle = (sheet.formed[a] + sheet.formed[b]) / 2;
    const double length = (sheet.formed[b] - sheet.formed[a]).norm();
    const Eigen::Vector3d here = area_vector(side), beside = area_vector(opposite[side]);
    const double height = std::min(here.norm(), beside.norm()) / length;
    const double reach = std::min(most_of_edge * length, most_of_height * height);
    if (!(reach > least_mm)) return std::nullopt;
    const Eigen::Vector3d way = reach * (here + beside).normalized();
    const auto touch = obstacles.first_touch(middle + way, middle - way);
    // At the very beginning it would already be in the mold there.
    if (!touch || touch->with != Contact::mold || touch->t == 0) return std::nullopt;
    return (touch->place - middle).norm() > least_mm ? std::optional(touch->place) : std::nullopt;
  };
  // The middle of an edge on the flat sheet: of a polynomial with the gradients that are known at its ends.
  const std::vector<Gradient> gradients = rest_gradients(sheet);
  const auto middle_of_rest = [&](int a, int b) -> Eigen::Vector2d {
    const Eigen::Vector2d edge = sheet.rest[b] - sheet.rest[a], line = (sheet.rest[a] + sheet.rest[b]) / 2;
    const Eigen::Vector3d formed = sheet.formed[b] - sheet.formed[a];
    Eigen::Vector2d at_a = gradients[a] * formed, at_b = gradients[b] * formed;
    if (!at_a.allFinite() && !at_b.allFinite()) return line;
    if (!at_a.allFinite()) at_a = 2 * edge - at_b;  // a parabola has the edge as the mean of both
    if (!at_b.allFinite()) at_b = 2 * edge - at_a;
    const Eigen::Vector2d off = (at_a - at_b) / 8;
    const double most = most_of_edge * edge.norm();  // the pieces stay upright
    return off.norm() <= most ? Eigen::Vector2d(line + off) : line;
  };
  const int sides = static_cast<int>(opposite.size());
  std::vector<std::optional<Eigen::Vector3d>> places(opposite.size());
  in_parallel(0, sides, [&](int begin, int end) {
    for (int side = begin; side < end; ++side) places[side] = bend(side);
  });

  std::vector<int> middles(opposite.size(), -1);  // the new vertex of each side
  for (int side = 0; side < sides; ++side) {
    if (!places[side]) continue;
    const int a = corner(side, 1), b = corner(side, 2);
    middles[side] = middles[opposite[side]] = static_cast<int>(sheet.formed.size());
    sheet.formed.push_back(*places[side]);
    sheet.rest.push_back(middle_of_rest(a, b));
    sheet.contact.push_back(Contact::mold);
    sheet.contact_time.push_back((sheet.contact_time[a] + sheet.contact_time[b]) / 2);
    sheet.temperature.push_back(temperature.at(sheet.rest.back()));
  }
  // The flat area over the formed one: what is left of the thickness.
  const auto left = [&](const Triangle& t) {
    return cross(sheet.rest[t[1]] - sheet.rest[t[0]], sheet.rest[t[2]] - sheet.rest[t[0]]) / 2 /
           formed_area(sheet, t);
  };
  const std::size_t before = sheet.triangles.size();
  for (std::size_t t = 0; t < before; ++t) {
    const Triangle whole = sheet.triangles[t];
    const auto pieces = pieces_of(whole, {middles[3 * t + 2], middles[3 * t], middles[3 * t + 1]});
    if (pieces.size() == 1) continue;
    const double unformed_mm = sheet.element_thickness[t] / left(whole);
    const std::uint8_t wrinkled = sheet.element_wrinkled[t];
    sheet.triangles[t] = pieces.front();
    sheet.element_thickness[t] = unformed_mm * left(pieces.front());
    for (std::size_t k = 1; k < pieces.size(); ++k) {
      sheet.triangles.push_back(pieces[k]);
      sheet.element_thickness.push_back(unformed_mm * left(pieces[k]));
      sheet.element_wrinkled.push_back(wrinkled);
    }
  }
}

}  // namespace vacuform
