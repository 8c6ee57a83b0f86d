#include "worker/printing/colour_ink.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int samples_a_side = 4;      // of a triangle
constexpr double least_lack = 0.01;    // coverage; what is less is not seen
constexpr double least_share = 0.001;  // of the coloured area, for a warning

// The average over the samples of a triangle.
struct TriangleInk {
  double coloured = 0, too_little = 0;  // shares of the triangle
  double lack = 0;                      // the largest, coverage
  std::size_t ink = 0;
  Vector3d place = Vector3d::Zero();
};

TriangleInk examine(const SheetColours& colours, const ColourInk& ink, int triangle) {
  const FormedSheet& sheet = colours.sheet();
  const Triangle& corners = sheet.triangles[triangle];
  std::array<Vector3d, 3> at;
  std::array<double, 3> ratio;
  for (std::size_t k = 0; k < 3; ++k) {
    at[k] = sheet.formed[corners[k]];
    ratio[k] = ink.area_ratios[corners[k]];
  }
  const Vector3d across = (at[1] - at[0]) / samples_a_side, down = (at[2] - at[0]) / samples_a_side;
  ColourWalk walk(colours.surface(), across, down);
  TriangleInk out;
  constexpr double each = 2.0 / (samples_a_side * (samples_a_side + 1));
  for (int i = 0; i < samples_a_side; ++i)
    for (int j = 0; i + j < samples_a_side; ++j) {
      const double u = (i + 1.0 / 3) / samples_a_side, v = (j + 1.0 / 3) / samples_a_side;
      const Vector3d place = at[0] + u * (at[1] - at[0]) + v * (at[2] - at[0]);
      const auto found = walk.at(place, colours.reach().end_mm());
      if (!found) continue;
      const double opacity = colours.reach().share(found->distance_mm);
      if (!(opacity > 0)) continue;
      out.coloured += each;
      const auto a = static_cast<float>(ratio[0] + u * (ratio[1] - ratio[0]) + v * (ratio[2] - ratio[0]));
      const Vector3f lack = ink.shown(found->linear, a) - found->linear;
      Eigen::Index worst = 0;
      const double most = opacity * static_cast<double>(lack.maxCoeff(&worst));
      if (most > least_lack) out.too_little += each;
      if (most > out.lack) out.lack = most, out.ink = static_cast<std::size_t>(worst), out.place = place;
    }
  return out;
}

double area_in_space(const InkedSurface& surface, const Triangle& t) {
  const auto at = [&](std::size_t k) -> const Vector3d& { return surface.inked()[t[k]]; };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
}

}  // namespace

Vector3f ColourInk::printed(const Vector3f& linear, float area_ratio) const {
  Vector3f out;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    out[c] = 1 - curve.printed(k, area_ratio * std::clamp(1 - linear[c], 0.0f, 1.0f));
  }
  return out;
}

Vector3f ColourInk::shown(const Vector3f& linear, float area_ratio) const {
  Vector3f out;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    out[c] = std::max(linear[c], 1 - curve.most(k) / std::max(area_ratio, 1e-6f));
  }
  return out;
}

Vector3f ColourInk::seen(const Vector3f& printed, float area_ratio) const {
  Vector3f out;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    out[c] = std::max(0.0f, 1 - curve.ink(k, 1 - printed[c]) / std::max(area_ratio, 1e-6f));
  }
  return out;
}

ColourInk colour_ink(const InkedSurface& surface, const InkCurveRows& curve) {
  std::vector<double> flat(surface.rest().size(), 0), formed(flat);
  for (const Triangle& t : surface.triangles()) {
    const auto rest = [&](std::size_t k) -> const Eigen::Vector2d& { return surface.rest()[t[k]]; };
    const double before = 0.5 * std::abs(cross(rest(1) - rest(0), rest(2) - rest(0))),
                 after = area_in_space(surface, t);
    for (const int v : t) flat[v] += before, formed[v] += after;
  }
  for (std::size_t v = 0; v < flat.size(); ++v) formed[v] = flat[v] > 0 ? formed[v] / flat[v] : 1;
  return {InkCurve(curve), std::move(formed)};
}

InkShortage ink_shortage(const SheetColours& colours, const InkedSurface& surface, const ColourInk& ink) {
  const std::vector<int>& triangles = colours.triangles();
  std::vector<TriangleInk> found(triangles.size());
  in_parallel(0, static_cast<int>(triangles.size()), [&](int first, int last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i)
      found[i] = examine(colours, ink, triangles[i]);
  });
  InkShortage out;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const double area = area_in_space(surface, surface.triangles()[triangles[i]]);
    out.coloured_mm2 += found[i].coloured * area;
    out.short_mm2 += found[i].too_little * area;
    if (found[i].lack > out.lack)
      out.lack = found[i].lack, out.ink = found[i].ink, out.place = found[i].place;
  }
  return out;
}

std::optional<Warning> warning_of(const InkShortage& shortage) {
  if (shortage.share() < least_share) return {};
  const double percent = 100 * shortage.share();
  return Warning{.code = "ink-not-enough",
                 .text = "On " + decimal(percent, 1) +
                         " % of the coloured area full ink is too little after the sheet has stretched; the "
                         "largest lack is " +
                         decimal(100 * shortage.lack, 0) + " % coverage of " + ink_names[shortage.ink],
                 .marks = {{{shortage.place.x(), shortage.place.y(), shortage.place.z()}}},
                 .figure = Warning::Figure{percent, "%", 100 * least_share}};
}

PrintedColours printed_colours(const SheetColours& colours, const InkedSurface& surface,
                               const PrintSettings& settings) {
  PrintedColours printed{colours};
  if (settings.compensate_colours) {
    printed.ink = colour_ink(surface, settings.ink_curve);
    printed.shortage = ink_shortage(colours, surface, *printed.ink);
  }
  return printed;
}

}  // namespace vacuform
