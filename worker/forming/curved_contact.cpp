#include "worker/forming/curved_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "worker/numerics/plane.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/adjacency.hpp"
#include "worker/surface/split_triangle.hpp"

namespace vacuform {

namespace {

constexpr double least_mm = 0.03, most_of_edge = 0.05, most_of_height = 0.1;

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
    sheet.rest.emplace_back((sheet.rest[a] + sheet.rest[b]) / 2);
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
