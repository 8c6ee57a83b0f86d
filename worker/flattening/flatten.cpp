// The region of interest becomes one chart, the chart is flattened, and the flattening is laid so that its origin is
// the top of the mold and it is turned as little as possible against the sheet.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "worker/flattening/chart.hpp"
#include "worker/flattening/flattening.hpp"

namespace vacuform {

namespace {

double area(const FormedSheet& sheet, int k) {
  const Triangle& t = sheet.triangles[k];
  return 0.5 *
         (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]).norm();
}

// Neighbours across the three edges, -1 on the sheet's border.
std::vector<std::array<int, 3>> neighbours(const std::vector<Triangle>& triangles) {
  std::map<std::pair<int, int>, std::pair<int, int>> open;
  std::vector<std::array<int, 3>> across(triangles.size(), {-1, -1, -1});
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k)
    for (int e = 0; e < 3; ++e) {
      const int a = triangles[k][e], b = triangles[k][(e + 1) % 3];
      const auto twin = open.find({b, a});
      if (twin == open.end()) {
        open[{a, b}] = {k, e};
      } else {
        across[k][e] = twin->second.first;
        across[twin->second.first][twin->second.second] = k;
        open.erase(twin);
      }
    }
  return across;
}

// Connected parts, across edges, of the triangles with inside[k] == wanted: a part number per triangle, else -1.
std::vector<int> parts(const std::vector<std::array<int, 3>>& across, const std::vector<char>& inside,
                       char wanted, int& count) {
  std::vector<int> part(inside.size(), -1), stack;
  count = 0;
  for (int seed = 0; seed < static_cast<int>(inside.size()); ++seed) {
    if (inside[seed] != wanted || part[seed] >= 0) continue;
    stack.assign(1, seed);
    part[seed] = count;
    while (!stack.empty()) {
      const int k = stack.back();
      stack.pop_back();
      for (int n : across[k])
        if (n >= 0 && inside[n] == wanted && part[n] < 0) part[n] = count, stack.push_back(n);
    }
    ++count;
  }
  return part;
}

// The largest part of the sheet that lies on the mold, with what it encloses.
std::vector<int> region_of_interest(const FormedSheet& sheet) {
  const auto across = neighbours(sheet.triangles);
  std::vector<char> inside;
  for (const Triangle& t : sheet.triangles)
    inside.push_back(
        std::all_of(t.begin(), t.end(), [&](int v) { return sheet.contact[v] == Contact::mold; }));

  int count = 0;
  const auto part = parts(across, inside, 1, count);
  std::vector<double> size(count, 0);
  for (std::size_t k = 0; k < part.size(); ++k)
    if (part[k] >= 0) size[part[k]] += area(sheet, static_cast<int>(k));
  const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  for (std::size_t k = 0; k < part.size(); ++k) inside[k] = count > 0 && part[k] == largest;

  // What does not reach the sheet's border without crossing the region is a hole of it.
  const auto rest = parts(across, inside, 0, count);
  std::vector<char> reaches_border(count, 0);
  for (std::size_t k = 0; k < rest.size(); ++k)
    if (rest[k] >= 0 && std::count(across[k].begin(), across[k].end(), -1) > 0) reaches_border[rest[k]] = 1;
  std::vector<int> region;
  for (std::size_t k = 0; k < rest.size(); ++k)
    if (inside[k] || (rest[k] >= 0 && !reaches_border[rest[k]])) region.push_back(static_cast<int>(k));
  return region;
}

// The face that carries the ink: the formed one, or the other, one thickness along the vertex normals.
std::vector<Eigen::Vector3d> inked_surface(const FormedSheet& sheet, InkedFace face) {
  std::vector<Eigen::Vector3d> inked = sheet.formed;
  if (face == InkedFace::inner) return inked;
  std::vector<Eigen::Vector3d> normal(inked.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : sheet.triangles) {
    const Eigen::Vector3d n =
        (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]);
    for (int v : t) normal[v] += n;
  }
  for (std::size_t i = 0; i < inked.size(); ++i)
    if (const double length = normal[i].norm(); length > 0)
      inked[i] += sheet.thickness[i] / length * normal[i];
  return inked;
}

// Where the vertical through the top of the mold meets the chart: a triangle and barycentric weights.
struct Spot {
  Triangle triangle;
  Eigen::Vector3d weights;
  bool exact;  // else the vertex nearest to the top
};
Spot find_top(const FormedSheet& sheet, const std::vector<int>& region, const Eigen::Vector3d& top) {
  Spot best{{}, {}, false};
  double best_z = -std::numeric_limits<double>::infinity(), nearest = std::numeric_limits<double>::infinity();
  for (const int k : region) {
    const Triangle& t = sheet.triangles[k];
    const Eigen::Vector3d &a = sheet.formed[t[0]], &b = sheet.formed[t[1]], &c = sheet.formed[t[2]];
    const double whole = (b - a).cross(c - a).z();
    const Eigen::Vector3d w((b - top).cross(c - top).z(), (c - top).cross(a - top).z(),
                            (a - top).cross(b - top).z());
    if (whole > 0 && w.minCoeff() >= 0) {
      const double z = (w.x() * a.z() + w.y() * b.z() + w.z() * c.z()) / whole;
      if (z > best_z) best_z = z, best = {t, w / whole, true};
    }
    for (int e = 0; e < 3 && !best.exact; ++e)
      if (const double d = (sheet.formed[t[e]] - top).norm(); d < nearest)
        nearest = d, best = {t, Eigen::Vector3d::Unit(e), false};
  }
  return best;
}

// Turns and shifts the chart: the least squares rotation towards the sheet's coordinates, weighted by formed area.
void align(Chart& chart, const std::vector<Eigen::Vector2d>& start) {
  Eigen::Vector2d mean_uv(0, 0), mean_st(0, 0);
  double total = 0;
  std::vector<double> weight(chart.uv.size(), 0);
  for (const Triangle& t : chart.triangles) {
    const FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    for (int v : t) weight[v] += f.length * f.height;
  }
  for (std::size_t i = 0; i < weight.size(); ++i)
    total += weight[i], mean_uv += weight[i] * chart.uv[i], mean_st += weight[i] * start[i];
  mean_uv /= total, mean_st /= total;
  double c = 0, s = 0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const Eigen::Vector2d u = chart.uv[i] - mean_uv, w = start[i] - mean_st;
    c += weight[i] * u.dot(w);
    s += weight[i] * (u.x() * w.y() - u.y() * w.x());
  }
  const Eigen::Rotation2Dd turn(std::atan2(s, c));
  for (auto& u : chart.uv) u = turn * u;
}

}  // namespace

Result<Flattening> flatten(const FormedSheet& sheet, const Mold& mold, const FlatteningSettings& settings,
                           InkedFace inked_face, const Context& context) {
  Flattening out;
  out.triangles = region_of_interest(sheet);
  if (out.triangles.size() < 8)
    return fail(Code::unusable_surface, "hardly any of the sheet lies on the mold", "forming",
                "give a finer sheet.resolution_mm, or a mold that is larger against it");
  out.inked = inked_surface(sheet, inked_face);

  // The chart's own numbering: sheet vertices in ascending order.
  std::vector<int> local(sheet.rest.size(), -1), global;
  for (const int k : out.triangles)
    for (int v : sheet.triangles[k]) local[v] = 0;
  Chart chart;
  for (std::size_t v = 0; v < local.size(); ++v) {
    if (local[v] < 0) continue;
    local[v] = static_cast<int>(global.size());
    global.push_back(static_cast<int>(v));
    chart.inked.push_back(out.inked[v]);
    chart.uv.push_back(sheet.rest[v]);
  }
  for (const int k : out.triangles) {
    const Triangle& t = sheet.triangles[k];
    chart.triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
  }

  const std::vector<Eigen::Vector2d> start = chart.uv;
  VACUFORM_TRY(outcome, settings.method == FlatteningMethod::arap ? flatten_arap(chart, context)
                                                                  : flatten_cgal_arap(chart, context));
  if (!outcome.converged)
    out.warnings.push_back({"flattening-not-converged", "The flattening stopped before it settled"});
  align(chart, start);
  const ChartQuality quality = chart_quality(chart);
  out.iterations = outcome.iterations;
  out.energy = quality.energy;
  out.flipped = quality.flipped;
  if (quality.flipped > 0)
    out.warnings.push_back(
        {"flattening-flipped", std::to_string(quality.flipped) +
                                   " triangles of the chart are folded over; the print is wrong there"});

  const Spot top = find_top(sheet, out.triangles, mold.top);
  if (!top.exact)
    out.warnings.push_back({"top-off-chart",
                            "The top of the mold is not covered by the chart; the pattern is centred "
                            "on the nearest point that is"});
  Eigen::Vector2d origin(0, 0);
  out.top_rest.setZero();
  for (int e = 0; e < 3; ++e) {
    origin += top.weights[e] * chart.uv[local[top.triangle[e]]];
    out.top_rest += top.weights[e] * sheet.rest[top.triangle[e]];
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  out.chart.assign(sheet.rest.size(), {nan, nan});
  for (std::size_t i = 0; i < global.size(); ++i) out.chart[global[i]] = chart.uv[i] - origin;
  context.report(Stage::flattening, 1);
  return out;
}

}  // namespace vacuform
