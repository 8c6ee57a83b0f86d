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
constexpr double most_of_circle = 1.1;  // over an edge of the sheet
constexpr double least_sharp = 1.1;     // a crest over the middle of an edge: less is a smooth arc
constexpr double least_piece = 0.03;    // of an edge or a triangle: no slivers
constexpr double most_reach_mm = 1;     // that corners are looked for
constexpr int rim_rounds = 3;
constexpr double most_dropped_mm = 0.3;  // that a crest stands out which is left out
constexpr double least_ever = 0.1;       // of the same: less is a sliver
constexpr double least_left = 0.3;       // of the thickness of a triangle in each of its pieces
constexpr double least_up = -0.3;        // z of a unit normal: steeper walls are noise of the grid
constexpr double least_area = 0.01;      // of a triangle in each of its pieces
constexpr double rounding = 1e-6;        // of a unit normal
constexpr double last_time = 2;          // FormedSheet::contact_time of what comes last
constexpr double least_smooth = 0.99;    // length of the mean of the normals around a vertex

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

// The crest of the mold over an edge of the sheet: the place where it stands out furthest.
struct Crest {
  Eigen::Vector3d place;
  double off_mm = 0;
};

// `out`: the unit vector across the edge away from the mold. Nothing if the mold stands out nowhere by rim_mm, or somewhere
// beyond the circle over the edge: a rim of up to 90 degrees lies in it (Thales).
std::optional<Crest> crest_over(const Obstacles& obstacles, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& out, double rim_mm) {
  const double length = (b - a).norm();
  Crest crest;
  bool beyond = false;
  const auto off = [&](double share) {
    const Eigen::Vector3d on_edge = (1 - share) * a + share * b;
    const auto touch = obstacles.first_touch(on_edge + length * out, on_edge);
    if (!touch || touch->with != Contact::mold) return 0.0;
    const double mm = (touch->place - on_edge).norm();
    beyond = beyond || mm > most_of_circle * length * std::sqrt(share * (1 - share));
    if (mm > crest.off_mm) crest = {touch->place, mm};
    return mm;
  };
  // A crest is seen at one of the quarters, by at least a third of what it stands out.
  if (std::max({off(0.25), off(0.5), off(0.75)}) <= rim_mm / 3) return std::nullopt;
  constexpr int samples = 16;
  double low = 0, highest = 0;
  for (int k = 1; k < samples; ++k)
    if (const double mm = off(double(k) / samples); mm > highest) highest = mm, low = double(k - 1) / samples;
  double high = low + 2.0 / samples;
  for (int i = 0; i < 12 && !beyond; ++i) {
    const double third = (high - low) / 3;
    if (off(low + third) < off(high - third))
      low += third;
    else
      high -= third;
  }
  return !beyond && crest.off_mm > rim_mm ? std::optional(crest) : std::nullopt;
}

// The flat area of a triangle over the formed one: what is left of the thickness.
template <class Rest, class Formed>
double left(const Rest& rest, const Formed& formed, const Triangle& t) {
  return cross(rest[t[1]] - rest[t[0]], rest[t[2]] - rest[t[0]]) /
         (formed[t[1]] - formed[t[0]]).cross(formed[t[2]] - formed[t[0]]).norm();
}

// Whether a piece would be much thinner than the triangle, or thicker: no sheet is, it comes from the division.
template <class Rest, class Formed>
bool divides_unevenly(const Rest& rest, const Formed& formed, const Triangle& whole,
                      const std::vector<Triangle>& pieces, double least = least_left) {
  const double before = left(rest, formed, whole);
  return std::ranges::any_of(pieces, [&](const Triangle& piece) {
    const double ratio = left(rest, formed, piece) / before;
    return !(ratio > least && ratio < 1 / least);
  });
}

// Whether a piece would lie upside down, or more so than the triangle, as over a grain of a rough mold; or be a sliver.
template <class Formed>
bool spoils(const Formed& formed, const Triangle& whole, const std::vector<Triangle>& pieces) {
  const auto area_vector = [&](const Triangle& t) -> Eigen::Vector3d {
    return (formed[t[1]] - formed[t[0]]).cross(formed[t[2]] - formed[t[0]]);
  };
  const Eigen::Vector3d before = area_vector(whole);
  const double most = std::min(least_up, before.stableNormalized().z() - rounding);
  return std::ranges::any_of(pieces, [&](const Triangle& piece) {
    const Eigen::Vector3d now = area_vector(piece);
    return now.stableNormalized().z() < most || now.norm() < least_area * before.norm();
  });
}

// Replaces a triangle by pieces of it: the first in its place, the others at the end. Each keeps its plastic.
void cut(FormedSheet& sheet, std::size_t triangle, const std::vector<Triangle>& pieces) {
  const auto left_of = [&](const Triangle& t) { return left(sheet.rest, sheet.formed, t); };
  const double unformed_mm = sheet.element_thickness[triangle] / left_of(sheet.triangles[triangle]);
  const std::uint8_t wrinkled = sheet.element_wrinkled[triangle];
  sheet.triangles[triangle] = pieces.front();
  sheet.element_thickness[triangle] = unformed_mm * left_of(pieces.front());
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    sheet.triangles.push_back(pieces[k]);
    sheet.element_thickness.push_back(unformed_mm * left_of(pieces[k]));
    sheet.element_wrinkled.push_back(wrinkled);
  }
}

// Gives the edges of the triangles that are `looked` at their vertices: on crests, and in a `smooth` round on the curvature
// between as well. Returns which triangles it changed or added.
std::vector<char> split_edges(FormedSheet& sheet, const Obstacles& obstacles,
                              const TemperatureField& temperature, const std::vector<char>& looked,
                              bool smooth, double rim_mm) {
  const std::vector<int> opposite = opposite_sides(sheet.triangles);
  const auto corner = [&](int side, int k) { return sheet.triangles[side / 3][(side % 3 + k) % 3]; };
  const auto area_vector = [&](int side) -> Eigen::Vector3d {
    const Eigen::Vector3d &a = sheet.formed[corner(side, 0)], &b = sheet.formed[corner(side, 1)],
                          &c = sheet.formed[corner(side, 2)];
    return (b - a).cross(c - a);
  };
  // The new vertex of an edge, found at the second of its sides: in space, and what part of the plastic of the edge lies
  // before it, where that is not left to the gradients.
  struct Bend {
    Eigen::Vector3d place;
    std::optional<double> before = {};
    double off_mm = 0;  // of a crest
  };
  const auto bend = [&](int side) -> std::optional<Bend> {
    const int a = corner(side, 1), b = corner(side, 2);
    const bool both = sheet.contact[a] == Contact::mold && sheet.contact[b] == Contact::mold;
    if (opposite[side] < 0 || opposite[side] > side || (!looked[side / 3] && !looked[opposite[side] / 3]))
      return std::nullopt;
    const Eigen::Vector3d &from = sheet.formed[a], &to = sheet.formed[b], middle = (from + to) / 2;
    const double length = (to - from).norm();
    const Eigen::Vector3d here = area_vector(side), beside = area_vector(opposite[side]);
    const double height = std::min(here.norm(), beside.norm()) / length;
    const double reach = smooth && both ? std::min(most_of_edge * length, most_of_height * height) : 0;
    const Eigen::Vector3d out = (here + beside).stableNormalized();
    const auto crest = crest_over(obstacles, from, to, out, rim_mm);
    const auto touch =
        reach > least_mm ? obstacles.first_touch(middle + reach * out, middle - reach * out) : std::nullopt;
    // At the very beginning it would already be in the mold there.
    if (touch && touch->with == Contact::mold && touch->t > 0) {
      const double off = (touch->place - middle).norm();
      if (!crest || crest->off_mm < least_sharp * off + least_mm)
        return off > least_mm ? std::optional(Bend{touch->place}) : std::nullopt;
    }
    if (!crest) return std::nullopt;
    const double first = (crest->place - from).norm(), second = (to - crest->place).norm();
    const double before = first / (first + second);
    return std::min(before, 1 - before) >= least_piece
               ? std::optional(Bend{crest->place, before, crest->off_mm})
               : std::nullopt;
  };
  // The middle of an edge on the flat sheet: of a polynomial with the gradients that are known at its ends.
  const std::vector<Gradient> gradients = smooth ? rest_gradients(sheet) : std::vector<Gradient>();
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
  std::vector<std::optional<Bend>> bends(opposite.size());
  in_parallel(0, sides, [&](int begin, int end) {
    for (int side = begin; side < end; ++side) bends[side] = bend(side);
  });

  // What turns a piece over is left out, and what divides the plastic of a triangle too unevenly, unless the mold would stand
  // out far; that changes the pieces of its neighbours.
  std::vector<std::optional<Eigen::Vector2d>> rests(opposite.size());
  for (int side = 0; side < sides; ++side)
    if (bends[side]) {
      const int a = corner(side, 1), b = corner(side, 2);
      const auto& before = bends[side]->before;
      rests[side] = before ? Eigen::Vector2d((1 - *before) * sheet.rest[a] + *before * sheet.rest[b])
                           : middle_of_rest(a, b);
      bends[opposite[side]] = bends[side], rests[opposite[side]] = rests[side];
    }
  enum class Division { even, uneven, over };
  const auto division = [&](int triangle) {
    const Triangle& t = sheet.triangles[triangle];
    std::array<Eigen::Vector2d, 6> rest;
    std::array<Eigen::Vector3d, 6> formed;
    std::array<int, 3> middles{-1, -1, -1};
    bool any = false, rim = false;
    for (int k = 0; k < 3; ++k) {
      rest[k] = sheet.rest[t[k]], formed[k] = sheet.formed[t[k]];
      const int side = 3 * triangle + (k + 2) % 3;  // from corner k to the next
      if (!bends[side]) continue;
      middles[k] = 3 + k, rest[3 + k] = *rests[side], formed[3 + k] = bends[side]->place;
      any = true, rim = rim || bends[side]->before;
    }
    if (!any) return Division::even;
    const auto pieces = pieces_of({0, 1, 2}, middles);
    if (spoils(formed, {0, 1, 2}, pieces) || divides_unevenly(rest, formed, {0, 1, 2}, pieces, least_ever))
      return Division::over;
    return rim && divides_unevenly(rest, formed, {0, 1, 2}, pieces) ? Division::uneven : Division::even;
  };
  for (bool again = true; again;) {
    again = false;
    for (int t = 0; t < sides / 3; ++t) {
      const Division divided = division(t);
      if (divided == Division::even) continue;
      int lowest = -1;
      double off = divided == Division::over ? HUGE_VAL : most_dropped_mm;
      for (int side = 3 * t; side < 3 * t + 3; ++side)
        if (bends[side] && (bends[side]->before || divided == Division::over) && bends[side]->off_mm < off)
          lowest = side, off = bends[side]->off_mm;
      if (lowest < 0) continue;
      bends[lowest] = bends[opposite[lowest]] = std::nullopt;
      again = true;
    }
  }

  std::vector<int> middles(opposite.size(), -1);  // the new vertex of each side
  for (int side = 0; side < sides; ++side) {
    if (!bends[side] || middles[side] >= 0) continue;
    const int a = corner(side, 1), b = corner(side, 2);
    middles[side] = middles[opposite[side]] = static_cast<int>(sheet.formed.size());
    sheet.formed.push_back(bends[side]->place);
    sheet.rest.push_back(*rests[side]);
    const double time = (sheet.contact_time[a] + sheet.contact_time[b]) / 2;
    sheet.contact_time.push_back(std::isnan(time) ? last_time : time);
    sheet.contact.push_back(Contact::mold);
    sheet.temperature.push_back(temperature.at(sheet.rest.back()));
  }
  std::vector<char> changed(sheet.triangles.size(), 0);
  for (std::size_t t = 0; t < changed.size(); ++t) {
    const auto pieces =
        pieces_of(sheet.triangles[t], {middles[3 * t + 2], middles[3 * t], middles[3 * t + 1]});
    changed[t] = pieces.size() > 1;
    if (pieces.size() > 1) cut(sheet, t, pieces);
  }
  changed.resize(sheet.triangles.size(), 1);
  return changed;
}

// Gives each triangle that a vertex of the mold stands out of by more than rim_mm a vertex there, the furthest of
// each. Returns which triangles it changed or added.
std::vector<char> catch_corners(FormedSheet& sheet, const TriangleMesh& mold,
                                const TemperatureField& temperature, double rim_mm) {
  std::vector<Eigen::Vector3d> normals(mold.vertices.size(), Eigen::Vector3d::Zero());
  std::vector<int> faces(mold.vertices.size(), 0);
  for (const Triangle& t : mold.triangles) {
    const Eigen::Vector3d &a = mold.vertices[t[0]], &b = mold.vertices[t[1]], &c = mold.vertices[t[2]];
    const Eigen::Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for (const int v : t) normals[v] += normal, ++faces[v];
  }
  const RayCaster rays({sheet.formed, sheet.triangles}, RayTree::quick);
  struct Corner {
    int vertex = -1;
    double off_mm = 0;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  };
  const auto count = static_cast<int>(mold.vertices.size());
  std::vector<std::optional<RayCaster::Hit>> hits(mold.vertices.size());
  in_parallel(0, count, [&](int begin, int end) {
    for (int v = begin; v < end; ++v)
      if (normals[v].norm() < least_smooth * faces[v])  // a corner, not curvature
        hits[v] = rays.first_hit(mold.vertices[v], -most_reach_mm * normals[v].stableNormalized());
  });
  std::vector<Corner> corners(sheet.triangles.size());
  for (int v = 0; v < count; ++v) {
    if (!hits[v] || hits[v]->t * most_reach_mm <= rim_mm) continue;
    const Triangle& t = sheet.triangles[hits[v]->triangle];
    const Eigen::Vector3d& a = sheet.formed[t[0]];
    const Eigen::Vector3d up = (sheet.formed[t[1]] - a).cross(sheet.formed[t[2]] - a);
    const Eigen::Vector3d weights(1 - hits[v]->u - hits[v]->v, hits[v]->u, hits[v]->v);
    Corner& corner = corners[hits[v]->triangle];
    const double off = hits[v]->t * most_reach_mm;
    if (up.dot(normals[v]) > 0 && weights.minCoeff() >= least_piece && off > corner.off_mm)
      corner = {v, off, weights};
  }
  std::vector<char> changed(sheet.triangles.size(), 0);
  for (std::size_t k = 0; k < changed.size(); ++k) {
    if (corners[k].vertex < 0) continue;
    const Triangle t = sheet.triangles[k];
    const int added = static_cast<int>(sheet.formed.size());
    Eigen::Vector2d rest = Eigen::Vector2d::Zero();
    double time = 0;
    for (int c = 0; c < 3; ++c) {
      rest += corners[k].weights[c] * sheet.rest[t[c]];
      time += sheet.contact_time[t[c]] / 3;
    }
    const std::vector<Triangle> pieces{{t[0], t[1], added}, {t[1], t[2], added}, {t[2], t[0], added}};
    sheet.formed.push_back(mold.vertices[corners[k].vertex]);
    sheet.rest.push_back(rest);
    if (divides_unevenly(sheet.rest, sheet.formed, t, pieces) || spoils(sheet.formed, t, pieces)) {
      sheet.formed.pop_back(), sheet.rest.pop_back();
      continue;
    }
    sheet.contact.push_back(Contact::mold);
    sheet.contact_time.push_back(std::isnan(time) ? last_time : time);
    sheet.temperature.push_back(temperature.at(rest));
    cut(sheet, k, pieces);
    changed[k] = 1;
  }
  changed.resize(sheet.triangles.size(), 1);
  return changed;
}

}  // namespace

void bend_to_mold(FormedSheet& sheet, const Obstacles& obstacles, const TemperatureField& temperature,
                  double rim_mm) {
  std::vector<char> looked(sheet.triangles.size(), 1);
  // The pieces of a triangle over a rim may have edges over it, too.
  for (int round = 0; round < rim_rounds; ++round) {
    std::vector<char> changed = split_edges(sheet, obstacles, temperature, looked, round == 0, rim_mm);
    looked = catch_corners(sheet, obstacles.mold(), temperature, rim_mm);
    for (std::size_t k = 0; k < changed.size(); ++k) looked[k] = looked[k] || changed[k];
    if (std::ranges::none_of(looked, [](char c) { return c != 0; })) return;
  }
}

}  // namespace vacuform
