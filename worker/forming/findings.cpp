#include "worker/forming/findings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "api/base/decimal.hpp"

namespace vacuform {

namespace {

// A connected part of the sheet that shares a fault.
struct Piece {
  std::vector<int> triangles;
  double area = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // its middle, on the sheet
  bool alone = true;                                // no vertex of it touches what it should not
};

Eigen::Vector3d centre(const FormedSheet& sheet, std::size_t triangle) {
  const Triangle& t = sheet.triangles[triangle];
  return (sheet.formed[t[0]] + sheet.formed[t[1]] + sheet.formed[t[2]]) / 3;
}

std::vector<double> formed_areas(const FormedSheet& sheet) {
  std::vector<double> area;
  for (const Triangle& t : sheet.triangles) area.push_back(formed_area(sheet, t));
  return area;
}

// Connected pieces of the chosen triangles, largest first; triangles hang together by a corner that `joins` allows.
std::vector<Piece> pieces(
    const FormedSheet& sheet, const std::vector<double>& area, const std::function<bool(std::size_t)>& chosen,
    const std::function<bool(int)>& joins = [](int) { return true; },
    const std::function<bool(int)>& spoils = [](int) { return false; }) {
  std::vector<int> root(sheet.rest.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  const auto first_joining = [&](const Triangle& t) { return std::find_if(t.begin(), t.end(), joins); };
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    if (!chosen(k)) continue;
    const auto first = first_joining(sheet.triangles[k]);
    for (auto v = first; v != sheet.triangles[k].end(); ++v)
      if (joins(*v)) root[find(*v)] = find(*first);
  }
  std::vector<Piece> by_root(root.size());
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    if (!chosen(k)) continue;
    const Triangle& t = sheet.triangles[k];
    Piece& piece = by_root[find(*first_joining(t))];
    piece.triangles.push_back(static_cast<int>(k));
    piece.area += area[k];
    piece.place += area[k] * centre(sheet, k);
    piece.alone = piece.alone && std::none_of(t.begin(), t.end(), spoils);
  }
  std::erase_if(by_root, [](const Piece& p) { return p.area == 0; });
  // The centre of a ring lies in its hole: the triangle nearest to it is a place on the sheet.
  for (Piece& p : by_root) {
    const Eigen::Vector3d middle = p.place / p.area;
    const auto off = [&](int k) {
      return (centre(sheet, static_cast<std::size_t>(k)) - middle).squaredNorm();
    };
    const int nearest = *std::min_element(p.triangles.begin(), p.triangles.end(),
                                          [&](int a, int b) { return off(a) < off(b); });
    p.place = centre(sheet, static_cast<std::size_t>(nearest));
  }
  std::stable_sort(by_root.begin(), by_root.end(),
                   [](const Piece& a, const Piece& b) { return a.area > b.area; });
  return by_root;
}

std::string at(const Eigen::Vector3d& p) {
  return "x = " + decimal(p.x(), 0) + " mm, y = " + decimal(p.y(), 0) + " mm, z = " + decimal(p.z(), 0) +
         " mm";
}

// Where the first of the pieces is, how large, and of how many.
std::string over(const std::vector<Piece>& largest_first) {
  const Piece& worst = largest_first.front();
  return "over " + decimal(worst.area, 0) + " mm2 at " + at(worst.place) +
         (largest_first.size() == 1 ? ""
                                    : ", the largest of " + std::to_string(largest_first.size()) + " places");
}

Warning::Mark mark(const Eigen::Vector3d& place, double size_mm) {
  return {{place.x(), place.y(), place.z()}, size_mm};
}

std::vector<Warning::Mark> marks_of(const std::vector<Piece>& worst_first) {
  std::vector<Warning::Mark> marks;
  for (std::size_t i = 0; i < std::min(worst_first.size(), Warning::most_marks); ++i)
    marks.push_back(mark(worst_first[i].place, 2 * std::sqrt(worst_first[i].area / std::numbers::pi)));
  return marks;
}

void find_not_reached(const FormedSheet& sheet, const std::vector<double>& area, const FindingLimits& limits,
                      std::vector<Warning>& warnings) {
  const auto is_free = [&](int v) { return sheet.contact[v] == Contact::free; };
  auto found = pieces(
      sheet, area,
      [&](std::size_t k) {
        return std::any_of(sheet.triangles[k].begin(), sheet.triangles[k].end(), is_free);
      },
      is_free,
      [&](int v) { return sheet.contact[v] == Contact::platform || sheet.contact[v] == Contact::clamp; });
  std::erase_if(found, [&](const Piece& p) { return !p.alone || p.area < limits.pocket_mm2; });
  const std::vector<Misfit>& bridged = sheet.fit.bridged;
  if (found.empty() && bridged.empty()) return;
  std::vector<Warning::Mark> marks = marks_of(found);
  for (std::size_t i = 0; i < bridged.size() && marks.size() < Warning::most_marks; ++i)
    marks.push_back(mark(bridged[i].place, bridged[i].size_mm));
  const auto off = [&] {
    return decimal(bridged.front().distance_mm, 1) + " mm off, at " + at(bridged.front().place);
  };
  if (found.empty())
    warnings.push_back({"not-reached", "Between places that touch the mold the sheet stays up to " + off(),
                        std::move(marks),
                        Warning::Figure{bridged.front().distance_mm, "mm", limits.fit.bridged_mm}});
  else
    warnings.push_back(
        {"not-reached",
         "The sheet bridges a hollow of the mold without reaching it, " + over(found) +
             (bridged.empty() ? "" : "; between places that touch the mold it stays up to " + off()),
         std::move(marks), Warning::Figure{found.front().area, "mm2", limits.pocket_mm2}});
}

void find_trapped_air(const FormedSheet& sheet, const TriangleMesh& mold, double sheet_thickness_mm,
                      const PocketLimits& limits, Findings& findings) {
  const auto pockets = trapped_air(sheet, mold, limits);
  if (pockets.empty()) return;
  findings.vents = vents_for(pockets, sheet, mold, sheet_thickness_mm);
  const Pocket& largest = pockets.front();
  const std::size_t holes = findings.vents.size();
  Warning warning{
      "trapped-air",
      "The sheet closes over a hollow of the mold before it reaches its bottom and shuts in air, " +
          decimal(largest.depth_mm, 1) + " mm deep over " + decimal(largest.area_mm2, 0) + " mm2 at " +
          at(findings.vents.front().place) +
          (pockets.size() == 1 ? "" : ", the largest of " + std::to_string(pockets.size()) + " places")};
  warning.fix = "Drill " + (holes == 1 ? "a vent" : std::to_string(holes) + " vents") + " of " +
                short_decimal(findings.vents.front().diameter_mm, 2) +
                " mm: they are listed under vents in report.json and marked in preview-findings.png.";
  for (std::size_t i = 0; i < std::min(holes, Warning::most_marks); ++i)
    warning.marks.push_back(mark(findings.vents[i].place, findings.vents[i].diameter_mm));
  warning.figure = Warning::Figure{largest.depth_mm, "mm", limits.depth_mm};
  findings.warnings.push_back(std::move(warning));
}

// Whether a triangle lies upside down without the mold's being so: the sheet hangs over. On a rough mold it may also be
// folded over a grain.
bool hangs_over(const FormedSheet& sheet, std::size_t triangle, bool rough) {
  constexpr double down = -0.3;  // of the normal: steeper walls are noise of the grid
  const Triangle& t = sheet.triangles[triangle];
  const Eigen::Vector3d& a = sheet.formed[t[0]];
  const Eigen::Vector3d normal = (sheet.formed[t[1]] - a).cross(sheet.formed[t[2]] - a);
  return normal.z() < down * normal.norm() &&
         (rough || std::any_of(t.begin(), t.end(), [&](int v) { return sheet.contact[v] != Contact::mold; }));
}

void find_webs(const FormedSheet& sheet, const std::vector<double>& area, const FindingLimits& limits,
               std::vector<Warning>& warnings) {
  const double least_mm2 = limits.web_mm2;
  const auto over_grain = [&](int k) {
    return limits.rough && hangs_over(sheet, static_cast<std::size_t>(k), true);
  };
  auto found = pieces(sheet, area, [&](std::size_t k) {
    return sheet.element_wrinkled[k] != 0 || hangs_over(sheet, k, limits.rough);
  });
  std::erase_if(found, [&](const Piece& p) {
    return p.area < least_mm2 && std::ranges::none_of(p.triangles, over_grain);
  });
  if (found.empty()) return;
  warnings.push_back({"webbing",
                      "The sheet is compressed sideways, or hangs over, and tends to fold, " + over(found),
                      marks_of(found), Warning::Figure{found.front().area, "mm2", least_mm2}});
}

// The largest principal stretch of each triangle.
std::vector<double> stretches(const FormedSheet& sheet) {
  std::vector<double> out;
  for (const Triangle& t : sheet.triangles) {
    Eigen::Matrix2d flat;
    flat << sheet.rest[t[1]] - sheet.rest[t[0]], sheet.rest[t[2]] - sheet.rest[t[0]];
    Eigen::Matrix<double, 3, 2> solid;
    solid << sheet.formed[t[1]] - sheet.formed[t[0]], sheet.formed[t[2]] - sheet.formed[t[0]];
    const Eigen::Matrix<double, 3, 2> F = solid * flat.inverse();
    const Eigen::Matrix2d C = F.transpose() * F;
    const double half = 0.5 * (C(0, 0) - C(1, 1));
    out.push_back(std::sqrt(0.5 * C.trace() + std::hypot(half, C(0, 1))));
  }
  return out;
}

void find_unstable(const FormedSheet& sheet, const std::vector<double>& area, const FindingLimits& limits,
                   std::vector<Warning>& warnings) {
  const std::vector<double> stretch = stretches(sheet);
  auto found = pieces(sheet, area, [&](std::size_t k) { return stretch[k] > limits.stretch; });
  std::erase_if(found, [&](const Piece& p) { return p.area < limits.stretch_mm2; });
  if (found.empty()) return;
  double most = 0;
  for (const Piece& p : found)
    for (const int k : p.triangles) most = std::max(most, stretch[k]);
  warnings.push_back(
      {"unstable-stretch",
       "The sheet stretches up to " + decimal(most, 1) + " times, " + over(found) + "; beyond " +
           decimal(limits.stretch, 0) +
           " times the neo-Hookean law hardens too little, and one place can take all the stretch",
       marks_of(found), Warning::Figure{most, "", limits.stretch}});
}

void find_pierced(const SurfaceFit& fit, double limit_mm, std::vector<Warning>& warnings) {
  if (fit.pierced.empty()) return;
  const Misfit& worst = fit.pierced.front();
  std::vector<Warning::Mark> marks;
  for (std::size_t i = 0; i < std::min(fit.pierced.size(), Warning::most_marks); ++i)
    marks.push_back(mark(fit.pierced[i].place, fit.pierced[i].size_mm));
  warnings.push_back(
      {"pierced",
       "The mold stands out of the simulated sheet by up to " + decimal(worst.distance_mm, 1) + " mm, at " +
           at(worst.place) +
           (fit.pierced.size() == 1 ? ""
                                    : ", the furthest of " + std::to_string(fit.pierced.size()) + " places") +
           ": the grid is too coarse for it",
       std::move(marks), Warning::Figure{worst.distance_mm, "mm", limit_mm}});
}

void find_thin(const FormedSheet& sheet, const std::vector<double>& area, double sheet_thickness_mm,
               double limit, std::vector<Warning>& warnings) {
  auto found = pieces(sheet, area,
                      [&](std::size_t k) { return sheet.element_thickness[k] < limit * sheet_thickness_mm; });
  if (found.empty()) return;
  const auto thickness = [&](int k) { return sheet.element_thickness[k]; };
  const auto thinner = [&](int a, int b) { return thickness(a) < thickness(b); };
  for (Piece& p : found) {
    std::iter_swap(p.triangles.begin(), std::min_element(p.triangles.begin(), p.triangles.end(), thinner));
    p.place = centre(sheet, static_cast<std::size_t>(p.triangles.front()));
  }
  std::stable_sort(found.begin(), found.end(), [&](const Piece& a, const Piece& b) {
    return thinner(a.triangles.front(), b.triangles.front());
  });
  const double least = thickness(found.front().triangles.front());
  warnings.push_back(
      {"thin",
       "The sheet thins to " + decimal(least, 2) + " mm, " + decimal(100 * least / sheet_thickness_mm, 0) +
           " % of its thickness, at " + at(found.front().place) +
           (found.size() == 1 ? "" : ", the thinnest of " + std::to_string(found.size()) + " places") +
           " below " + decimal(100 * limit, 0) + " %",
       marks_of(found), Warning::Figure{100 * least / sheet_thickness_mm, "%", 100 * limit}});
}

void find_extrapolated(const FormedSheet& sheet, std::vector<Warning>& warnings) {
  if (!sheet.summary.extrapolation) return;
  const Extrapolation& e = *sheet.summary.extrapolation;
  warnings.push_back({"fast-forming",
                      "The sheet is extrapolated from grids of " + short_decimal(e.coarse_mm) + " and " +
                          short_decimal(e.fine_mm) +
                          " mm: this moved 95 % of what touches the mold by at most " + decimal(e.p95, 2) +
                          " mm",
                      {},
                      Warning::Figure{e.p95, "mm"}});
}

void find_half_steps(const FormedSheet& sheet, std::vector<Warning>& warnings) {
  if (!sheet.summary.half_steps) return;
  warnings.push_back(
      {"half-steps", "In the usual steps the simulated sheet failed or tore; it was formed in half of them"});
}

}  // namespace

Findings forming_findings(const FormedSheet& sheet, const TriangleMesh& mold, double sheet_thickness_mm,
                          const FindingLimits& limits) {
  Findings findings;
  const std::vector<double> area = formed_areas(sheet);
  find_not_reached(sheet, area, limits, findings.warnings);
  find_trapped_air(sheet, mold, sheet_thickness_mm, limits.trapped, findings);
  find_unstable(sheet, area, limits, findings.warnings);
  find_pierced(sheet.fit, limits.fit.pierced_mm, findings.warnings);
  find_webs(sheet, area, limits, findings.warnings);
  find_thin(sheet, area, sheet_thickness_mm, limits.thickness_ratio, findings.warnings);
  find_half_steps(sheet, findings.warnings);
  find_extrapolated(sheet, findings.warnings);
  return findings;
}
std::optional<Tear> torn_at(const FormedSheet& sheet) {
  constexpr double torn_stretch = 10, torn_mm2 = 25;
  const std::vector<double> stretch = stretches(sheet), area = formed_areas(sheet);
  auto found = pieces(sheet, area, [&](std::size_t k) { return stretch[k] > torn_stretch; });
  if (found.empty() || found.front().area < torn_mm2) return std::nullopt;
  Tear tear{found.front().place, found.front().area, 0};
  for (const int k : found.front().triangles) tear.stretch = std::max(tear.stretch, stretch[k]);
  return tear;
}

}  // namespace vacuform
