#include "worker/placement/segments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "worker/flattening/methods.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/numerics/rigid_fit.hpp"
#include "worker/pattern/area.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/adjacency.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t smallest = 32;  // triangles: segments below this are not cut further
// How far joined segments may lie from their place in the chart (RMS): mm, or of the square root of their area.
constexpr double in_place_mm = 3, in_place = 0.05;
constexpr int stitches = 200;    // rounds of moving the segments towards each other
constexpr double anchor = 0.01;  // weight of the place of a segment in the chart, relative to its seams

// The places of the vertices of a segment in the chart.
std::vector<Vector2d> places_in_chart(const Region& region, const Segment& segment) {
  std::vector<Vector2d> out(segment.patch.uv.size());
  for (std::size_t i = 0; i < segment.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      out[index(segment.patch.triangles[i][k])] =
          region.chart.uv[index(region.chart.triangles[index(segment.triangles[i])][k])];
  return out;
}

// Whether a segment that is fitted rigidly to the chart lies about where the chart has it. A long strip around a dome
// or a horn may be flattened without distortion, but it opens, and parts of a drawing made for the whole then fall onto
// other places.
bool stays_in_place(const Region& region, const Segment& segment, double scale) {
  const std::vector<Vector2d> places = places_in_chart(region, segment);
  RigidFit fit;
  for (std::size_t v = 0; v < places.size(); ++v) fit.add(segment.patch.uv[v], places[v], 1);
  const Eigen::Isometry2d motion = fit.motion();
  double squares = 0, area = 0;
  for (std::size_t v = 0; v < places.size(); ++v)
    squares += (motion * segment.patch.uv[v] - places[v]).squaredNorm();
  for (const int t : segment.triangles) area += region.area[index(t)];
  const double off = scale * std::sqrt(squares / static_cast<double>(places.size()));
  return off <= std::max(in_place_mm, in_place * std::sqrt(area));
}

// Whether the flattened patch overlaps itself: a place of the drawing would then map to two places on the sheet.
bool overlaps_itself(const Patch& patch) {
  constexpr double rounding = 1e-6, rounding_mm2 = 1e-3;  // of its area, and at least
  // A union leaves out points within 0.0005 mm of a line, which alone can be more than that: so it is of a larger patch.
  constexpr double larger = 100;
  double area = 0;
  for (const Triangle& t : patch.triangles) {
    const Vector2d a = patch.uv[index(t[1])] - patch.uv[index(t[0])],
                   b = patch.uv[index(t[2])] - patch.uv[index(t[0])];
    area += cross(a, b) / 2;
  }
  const auto loops = border_loops(patch.triangles);
  std::vector<Ring> border;
  for (const auto& loop : loops) {
    border.emplace_back();
    for (const int v : loop) border.back().push_back(larger * patch.uv[index(v)]);
  }
  if (area - square_mm(union_of(border)) / (larger * larger) > std::max(rounding_mm2, rounding * area))
    return true;
  // However little it overlaps, its border may be found elsewhere, as the sides of a seam are in the print.
  const PlaneLocator locator(patch.triangles, patch.uv);
  constexpr double same_mm = 0.05;
  const auto elsewhere = [&](const Vector2d& uv, const Vector3d& place) {
    const auto found = locator.nearest(uv, 1e-3);
    return !found || (interpolate(patch.triangles, *found, patch.inked) - place).norm() > same_mm;
  };
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto a = index(loop[i]), b = index(loop[(i + 1) % loop.size()]);
      if (elsewhere(patch.uv[a], patch.inked[a]) ||
          elsewhere((patch.uv[a] + patch.uv[b]) / 2, (patch.inked[a] + patch.inked[b]) / 2))
        return true;
    }
  return false;
}

Result<Segment> flattened(const Region& region, Faces faces, double scale, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  Segment out{part_of(region, faces), std::move(faces), 1};
  Chart chart{out.patch.triangles, {}, out.patch.uv};
  for (const Vector3d& p : out.patch.inked) chart.inked.push_back(p / scale);
  VACUFORM_CHECK(flatten_arap(chart, Context()));  // its progress does not count for the job
  out.patch.uv = std::move(chart.uv);
  out.distortion = overlaps_itself(out.patch) ? std::numeric_limits<double>::infinity()
                                              : patch_distortion(out.patch, scale);
  return out;
}

// Segments below the limit, each from one piece of `open` or a part of it.
Result<std::vector<Segment>> cut(const Region& region, std::vector<Faces> open, double scale, double limit,
                                 const Context& context) {
  std::vector<Segment> done;
  while (!open.empty()) {
    VACUFORM_TRY(segment, flattened(region, std::move(open.back()), scale, context));
    open.pop_back();
    std::vector<Faces> parts;
    if (segment.distortion > limit && segment.triangles.size() >= smallest)
      parts = halves(region, segment.triangles);
    if (parts.size() < 2)
      done.push_back(std::move(segment));
    else
      for (Faces& part : parts) open.push_back(std::move(part));
  }
  return done;
}

// The edges between two segments, or of a slit in one, each seen from a triangle on its first side.
struct Side {
  int triangle, beside;
  std::size_t edge;
  double mm;
  bool cut;  // by a given cut, not by this algorithm
};
using Borders = std::map<std::pair<int, int>, std::vector<Side>>;

Borders borders(const Region& region, const std::vector<Segment>& segments) {
  std::vector<int> of(region.area.size(), -1);
  for (std::size_t s = 0; s < segments.size(); ++s)
    for (const int t : segments[s].triangles) of[index(t)] = static_cast<int>(s);
  Borders out;
  for (std::size_t t = 0; t < of.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const int n = region.beside[t][e];
      if (n < 0) continue;
      const bool given = region.across[t][e] < 0, slit = of[t] == of[index(n)];
      if (of[t] > of[index(n)] || (slit && (!given || static_cast<int>(t) > n))) continue;  // each edge once
      const Triangle& c = region.chart.triangles[t];
      const double mm = (region.chart.inked[index(c[e])] - region.chart.inked[index(c[(e + 1) % 3])]).norm();
      out[{of[t], of[index(n)]}].push_back({static_cast<int>(t), n, e, mm, given});
    }
  return out;
}

// Neighbours and the length over which they may be joined, the longest first.
std::vector<std::pair<double, std::pair<int, int>>> to_join(const Borders& borders) {
  std::vector<std::pair<double, std::pair<int, int>>> out;
  for (const auto& [key, border] : borders) {
    double mm = 0;
    for (const Side& side : border) mm += side.cut ? 0 : side.mm;
    if (mm > 0) out.emplace_back(-mm, key);
  }
  std::sort(out.begin(), out.end());
  return out;
}

// Joins neighbours, longest seams first, if the two together stay below the limit and in their place.
Result<void> join(const Region& region, std::vector<Segment>& segments, double scale, double limit,
                  const Context& context) {
  std::map<std::pair<int, int>, bool> refused;  // by first triangles: whether they cannot be joined
  for (;;) {
    bool joined = false;
    for (const auto& [mm, key] : to_join(borders(region, segments))) {
      const auto a = index(key.first), b = index(key.second);
      const std::pair names{segments[a].triangles.front(), segments[b].triangles.front()};
      auto& no = refused[names];
      if (no) continue;
      Faces both = segments[a].triangles;
      both.insert(both.end(), segments[b].triangles.begin(), segments[b].triangles.end());
      std::sort(both.begin(), both.end());
      VACUFORM_TRY(whole, flattened(region, std::move(both), scale, context));
      if (whole.distortion > limit || !stays_in_place(region, whole, scale)) {
        no = true;
        continue;
      }
      segments[a] = std::move(whole);
      segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(b));
      std::erase_if(refused, [&](const auto& entry) {
        return entry.first.first == names.first || entry.first.second == names.first ||
               entry.first.first == names.second || entry.first.second == names.second;
      });
      joined = true;
      break;
    }
    if (!joined) return {};
  }
}

// An end of an edge of a seam: the vertex, and where its two sides have it in the pattern.
struct End {
  int vertex;
  int a, b;  // in the patches of the segments of the seam
  double weight;
};
std::vector<End> ends_of(const Region& region, const std::vector<Segment>& segments,
                         const std::pair<int, int>& of, const std::vector<Side>& border) {
  const auto local = [&](int segment, int triangle, int vertex) {
    const Segment& s = segments[index(segment)];
    const auto row = std::lower_bound(s.triangles.begin(), s.triangles.end(), triangle) - s.triangles.begin();
    const Triangle& corners = region.chart.triangles[index(triangle)];
    const auto k = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
    return s.patch.triangles[row][k];
  };
  std::vector<End> out;
  for (const Side& side : border)
    for (const std::size_t k : {side.edge, (side.edge + 1) % 3}) {
      const int v = region.chart.triangles[index(side.triangle)][k];
      out.push_back({v, local(of.first, side.triangle, v), local(of.second, side.beside, v), side.mm / 2});
    }
  return out;
}

// Moves each segment rigidly so that the sides of its seams approach those of its neighbours, tied weakly to the chart.
void stitch(const Region& region, std::vector<Segment>& segments, const Borders& seams) {
  struct Tie {
    std::size_t other;
    int own, its;
    double weight;
  };
  std::vector<std::vector<Tie>> ties(segments.size());
  for (const auto& [key, border] : seams) {
    if (key.first == key.second) continue;
    const auto a = index(key.first), b = index(key.second);
    for (const End& end : ends_of(region, segments, key, border)) {
      ties[a].push_back({b, end.a, end.b, end.weight});
      ties[b].push_back({a, end.b, end.a, end.weight});
    }
  }
  std::vector<std::vector<Vector2d>> places;
  for (const Segment& segment : segments) places.push_back(places_in_chart(region, segment));
  for (int round = 0; round < stitches; ++round)
    for (std::size_t s = 0; s < segments.size(); ++s) {
      RigidFit fit;
      Patch& patch = segments[s].patch;
      for (const Tie& tie : ties[s])
        fit.add(patch.uv[index(tie.own)], segments[tie.other].patch.uv[index(tie.its)], tie.weight);
      for (std::size_t v = 0; v < patch.uv.size(); ++v) fit.add(patch.uv[v], places[s][v], anchor);
      const Eigen::Isometry2d motion = fit.motion();
      for (Vector2d& p : patch.uv) p = motion * p;
    }
}

std::vector<Seam> measured(const Region& region, const std::vector<Segment>& segments, const Borders& seams) {
  std::vector<Seam> out;
  for (const auto& [key, border] : seams) {
    Seam seam{key.first, key.second, 0, 0, 0, Vector3d::Zero(), {}};
    for (const Side& side : border) {
      seam.length_mm += side.mm;
      const auto& back = region.beside[index(side.beside)];
      const auto edge = std::find(back.begin(), back.end(), side.triangle) - back.begin();
      seam.edges.push_back({side.triangle, static_cast<int>(side.edge), side.beside, static_cast<int>(edge)});
    }
    const auto ends = ends_of(region, segments, key, border);
    Vector3d middle = Vector3d::Zero();
    for (const End& end : ends) {
      const double jump = (segments[index(key.first)].patch.uv[index(end.a)] -
                           segments[index(key.second)].patch.uv[index(end.b)])
                              .norm();
      seam.mean_jump_mm += end.weight * jump / seam.length_mm;
      seam.max_jump_mm = std::max(seam.max_jump_mm, jump);
      middle += end.weight * region.chart.inked[index(end.vertex)] / seam.length_mm;
    }
    const auto off = [&](const End& end) { return (region.chart.inked[index(end.vertex)] - middle).norm(); };
    const auto nearest = std::min_element(ends.begin(), ends.end(),
                                          [&](const End& p, const End& q) { return off(p) < off(q); });
    seam.place = region.chart.inked[index(nearest->vertex)];
    out.push_back(std::move(seam));
  }
  return out;
}

}  // namespace

double patch_distortion(const Patch& patch, double scale) {
  std::vector<std::pair<double, double>> figures;  // figure, inked area
  double total = 0;
  for (const Triangle& t : patch.triangles) {
    const FlatTriangle f =
        flat_triangle(patch.inked[index(t[0])], patch.inked[index(t[1])], patch.inked[index(t[2])]);
    Eigen::Matrix2d flat, drawn;
    flat << f.length, f.along, 0, f.height;
    drawn << patch.uv[index(t[1])] - patch.uv[index(t[0])], patch.uv[index(t[2])] - patch.uv[index(t[0])];
    const Eigen::Matrix2d map = flat * (scale * drawn).inverse();
    const double half = map.squaredNorm() / 2, det = map.determinant();
    const double root = std::sqrt(std::max(0.0, half * half - det * det));
    const double s1 = std::sqrt(half + root), s2 = det > 0 ? det / s1 : 0;  // turned over: the worst value
    const double figure =
        s2 > 0 && std::isfinite(s1) ? std::max(s1, 1 / s2) : std::numeric_limits<double>::infinity();
    figures.emplace_back(figure, f.length * f.height / 2);
    total += f.length * f.height / 2;
  }
  std::sort(figures.begin(), figures.end());
  double sum = 0;
  for (const auto& [figure, area] : figures)
    if ((sum += area) >= 0.95 * total) return figure;
  return 1;
}

Result<Segments> cut_into_segments(const Patch& chart, double scale, double limit,
                                   const std::vector<Edge>& cuts, const Context& context) {
  const Region region(chart, cuts);
  Faces all(region.area.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<int>(t);
  std::vector<Faces> pieces = connected(region, all);
  const std::size_t given = pieces.size();
  VACUFORM_TRY(segments, cut(region, std::move(pieces), scale, limit, context));
  VACUFORM_CHECK(join(region, segments, scale, limit, context));
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.triangles.front() < b.triangles.front(); });
  const Borders seams = borders(region, segments);
  stitch(region, segments, seams);
  Segments out;
  out.seams = measured(region, segments, seams);
  out.cuts_sufficed = segments.size() == given;
  out.parts = std::move(segments);
  return out;
}

}  // namespace vacuform
