#include "worker/coils/segments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <queue>
#include <tuple>

#include "worker/flattening/methods.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t smallest = 32;  // triangles that are not cut any more
constexpr int stitches = 200;         // rounds of moving the segments towards each other
constexpr double anchor = 0.01;       // how much a segment's place in the chart counts against its seams

std::size_t index(int i) { return static_cast<std::size_t>(i); }

struct Region {
  explicit Region(const Patch& of) : chart(of), across(of.triangles.size(), {-1, -1, -1}) {
    std::map<std::pair<int, int>, std::pair<int, std::size_t>> open;
    for (std::size_t t = 0; t < chart.triangles.size(); ++t) {
      const Triangle& c = chart.triangles[t];
      const Vector3d &p = chart.inked[index(c[0])], &q = chart.inked[index(c[1])],
                     &r = chart.inked[index(c[2])];
      middle.push_back((p + q + r) / 3);
      area.push_back((q - p).cross(r - p).norm() / 2);
      for (std::size_t e = 0; e < 3; ++e) {
        const int a = c[e], b = c[(e + 1) % 3];
        if (const auto twin = open.find({b, a}); twin != open.end()) {
          across[t][e] = twin->second.first;
          across[index(twin->second.first)][twin->second.second] = static_cast<int>(t);
        } else {
          open[{a, b}] = {static_cast<int>(t), e};
        }
      }
    }
  }
  const Patch& chart;
  std::vector<std::array<int, 3>> across;  // neighbours over the edges (0 1), (1 2), (2 0); -1 at the border
  std::vector<Vector3d> middle;
  std::vector<double> area;
};

using Faces = std::vector<int>;  // triangles of the region, ascending

// The part of the chart that these triangles are.
Patch part_of(const Patch& chart, const Faces& faces) {
  Patch out;
  std::vector<int> local(chart.uv.size(), -1);
  for (const int t : faces) {
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = index(chart.triangles[index(t)][k]);
      if (local[v] < 0) {
        local[v] = static_cast<int>(out.uv.size());
        out.uv.push_back(chart.uv[v]);
        out.rest.push_back(chart.rest[v]);
        out.inked.push_back(chart.inked[v]);
      }
      corners[k] = local[v];
    }
    out.triangles.push_back(corners);
  }
  return out;
}

// The nearest of the seeds to each triangle of `faces` by way of its neighbours among them, and how far it is.
struct Nearest {
  std::vector<int> seed;  // over the region; -1 elsewhere
  std::vector<double> mm;
};
Nearest nearest_seed(const Region& region, const Faces& faces, const std::vector<int>& seeds) {
  Nearest out{std::vector<int>(region.area.size(), -1), std::vector<double>(region.area.size(), -1)};
  for (const int t : faces) out.mm[index(t)] = std::numeric_limits<double>::infinity();
  using Entry = std::tuple<double, int, int>;  // distance, triangle, seed
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t s = 0; s < seeds.size(); ++s) queue.emplace(0, seeds[s], static_cast<int>(s));
  while (!queue.empty()) {
    const auto [mm, t, seed] = queue.top();
    queue.pop();
    if (out.seed[index(t)] >= 0) continue;
    out.seed[index(t)] = seed;
    out.mm[index(t)] = mm;
    for (const int n : region.across[index(t)])
      if (n >= 0 && out.seed[index(n)] < 0 && out.mm[index(n)] >= 0)
        queue.emplace(mm + (region.middle[index(n)] - region.middle[index(t)]).norm(), n, seed);
  }
  return out;
}

// A triangle of which two sides look into the other part joins it: seams without teeth.
void smooth(const Region& region, const Faces& faces, std::vector<int>& part) {
  for (int round = 0; round < 4; ++round)
    for (const int t : faces) {
      int others = 0, own = 0;
      for (const int n : region.across[index(t)]) {
        if (n < 0 || part[index(n)] < 0) continue;
        ++(part[index(n)] == part[index(t)] ? own : others);
      }
      if (others == 2 && own == 1) part[index(t)] = 1 - part[index(t)];
    }
}

std::vector<Faces> connected(const Region& region, const Faces& faces) {
  std::vector<char> inside(region.area.size(), 0);
  for (const int t : faces) inside[index(t)] = 1;
  std::vector<Faces> out;
  for (const int first : faces) {
    if (!inside[index(first)]) continue;
    Faces piece{first};
    inside[index(first)] = 0;
    for (std::size_t i = 0; i < piece.size(); ++i)
      for (const int n : region.across[index(piece[i])])
        if (n >= 0 && inside[index(n)]) inside[index(n)] = 0, piece.push_back(n);
    std::sort(piece.begin(), piece.end());
    out.push_back(std::move(piece));
  }
  return out;
}

std::vector<Faces> halves(const Region& region, const Faces& faces) {
  const auto farthest = [&](int from) {
    const Nearest way = nearest_seed(region, faces, {from});
    return *std::max_element(faces.begin(), faces.end(),
                             [&](int a, int b) { return way.mm[index(a)] < way.mm[index(b)]; });
  };
  std::vector<int> seeds{farthest(faces.front())};
  seeds.push_back(farthest(seeds.front()));
  std::vector<int> part;
  for (int round = 0; round < 6; ++round) {
    part = nearest_seed(region, faces, seeds).seed;
    for (int side = 0; side < 2; ++side) {
      Vector3d sum = Vector3d::Zero();
      double total = 0;
      for (const int t : faces)
        if (part[index(t)] == side)
          sum += region.area[index(t)] * region.middle[index(t)], total += region.area[index(t)];
      double best = std::numeric_limits<double>::infinity();
      for (const int t : faces)
        if (const double d = (region.middle[index(t)] - sum / total).norm();
            part[index(t)] == side && d < best)
          best = d, seeds[index(side)] = t;
    }
  }
  smooth(region, faces, part);
  std::vector<Faces> out;
  for (int side = 0; side < 2; ++side) {
    Faces half;
    for (const int t : faces)
      if (part[index(t)] == side) half.push_back(t);
    for (Faces& piece : connected(region, half)) out.push_back(std::move(piece));
  }
  return out;
}

struct Segment {
  Faces faces;
  Patch patch;
  double distortion = 1;
};

Result<Segment> flattened(const Region& region, Faces faces, double scale, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  Segment out{std::move(faces), {}, 1};
  out.patch = part_of(region.chart, out.faces);
  Chart chart{out.patch.triangles, {}, out.patch.uv};
  for (const Vector3d& p : out.patch.inked) chart.inked.push_back(p / scale);
  VACUFORM_CHECK(flatten_arap(chart, Context()));  // its progress is none of the job's
  out.patch.uv = std::move(chart.uv);
  out.distortion = patch_distortion(out.patch, scale);
  return out;
}

Result<std::vector<Segment>> cut(const Region& region, double scale, double limit, const Context& context) {
  std::vector<Segment> done;
  Faces all(region.area.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<int>(t);
  std::vector<Faces> open = connected(region, all);
  while (!open.empty()) {
    VACUFORM_TRY(segment, flattened(region, std::move(open.back()), scale, context));
    open.pop_back();
    if (segment.distortion <= limit || segment.faces.size() < smallest)
      done.push_back(std::move(segment));
    else
      for (Faces& half : halves(region, segment.faces)) open.push_back(std::move(half));
  }
  return done;
}

// Edges between two segments: length and one vertex, by pair.
struct Border {
  double mm = 0;
  std::vector<std::pair<int, double>> vertices;  // of the chart, with half of the lengths of the edges at it
};
using Borders = std::map<std::pair<int, int>, Border>;

Borders borders(const Region& region, const std::vector<Segment>& segments) {
  std::vector<int> of(region.area.size(), -1);
  for (std::size_t s = 0; s < segments.size(); ++s)
    for (const int t : segments[s].faces) of[index(t)] = static_cast<int>(s);
  std::map<std::pair<int, int>, std::map<int, double>> weights;
  Borders out;
  for (std::size_t t = 0; t < of.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const int n = region.across[t][e];
      if (n < 0 || of[t] >= of[index(n)]) continue;  // each edge once
      const int a = region.chart.triangles[t][e], b = region.chart.triangles[t][(e + 1) % 3];
      const double mm = (region.chart.inked[index(a)] - region.chart.inked[index(b)]).norm();
      const std::pair key{of[t], of[index(n)]};
      out[key].mm += mm;
      weights[key][a] += mm / 2, weights[key][b] += mm / 2;
    }
  for (auto& [key, border] : out) border.vertices.assign(weights[key].begin(), weights[key].end());
  return out;
}

// Joins neighbours, those with the longest seams first, where the two together stay below the limit.
Result<void> join(const Region& region, std::vector<Segment>& segments, double scale, double limit,
                  const Context& context) {
  std::map<std::pair<int, int>, bool> refused;  // by first triangles: these two do not go together
  for (;;) {
    std::vector<std::pair<double, std::pair<int, int>>> pairs;
    for (const auto& [key, border] : borders(region, segments)) pairs.emplace_back(-border.mm, key);
    std::sort(pairs.begin(), pairs.end());
    bool joined = false;
    for (const auto& [mm, key] : pairs) {
      const auto a = index(key.first), b = index(key.second);
      const std::pair names{segments[a].faces.front(), segments[b].faces.front()};
      auto& no = refused[names];
      if (no) continue;
      Faces both = segments[a].faces;
      both.insert(both.end(), segments[b].faces.begin(), segments[b].faces.end());
      std::sort(both.begin(), both.end());
      VACUFORM_TRY(whole, flattened(region, std::move(both), scale, context));
      if (whole.distortion > limit) {
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

// Weighted points that a rigid motion takes as near as it can to others (Kabsch, in the plane).
class RigidFit {
 public:
  void add(const Vector2d& from, const Vector2d& to, double weight) {
    pairs_.push_back({from, to, weight});
    weight_ += weight, from_ += weight * from, to_ += weight * to;
  }
  Eigen::Isometry2d motion() const {
    const Vector2d from = from_ / weight_, to = to_ / weight_;
    double c = 0, s = 0;
    for (const auto& [p, q, w] : pairs_) {
      const Vector2d a = p - from, b = q - to;
      c += w * a.dot(b), s += w * (a.x() * b.y() - a.y() * b.x());
    }
    Eigen::Isometry2d out = Eigen::Isometry2d::Identity();
    out.rotate(Eigen::Rotation2Dd(std::atan2(s, c)));
    out.translation() = to - out.linear() * from;
    return out;
  }

 private:
  struct Pair {
    Vector2d from, to;
    double weight;
  };
  std::vector<Pair> pairs_;
  double weight_ = 0;
  Vector2d from_{0, 0}, to_{0, 0};
};

// Where the vertices of the chart are in a segment's own numbering.
std::map<int, std::size_t> numbering(const Patch& chart, const Segment& segment) {
  std::map<int, std::size_t> out;
  for (std::size_t i = 0; i < segment.faces.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      out[chart.triangles[index(segment.faces[i])][k]] = index(segment.patch.triangles[i][k]);
  return out;
}

// Moves each segment rigidly so that the sides of its seams come near those of its neighbours, tied weakly to the chart.
void stitch(const Region& region, std::vector<Segment>& segments, const Borders& seams) {
  std::vector<std::map<int, std::size_t>> local;
  for (const Segment& s : segments) local.push_back(numbering(region.chart, s));
  for (int round = 0; round < stitches; ++round)
    for (std::size_t s = 0; s < segments.size(); ++s) {
      RigidFit fit;
      Patch& patch = segments[s].patch;
      for (const auto& [key, border] : seams) {
        if (key.first != static_cast<int>(s) && key.second != static_cast<int>(s)) continue;
        const std::size_t other = index(key.first == static_cast<int>(s) ? key.second : key.first);
        for (const auto& [v, weight] : border.vertices)
          fit.add(patch.uv[local[s][v]], segments[other].patch.uv[local[other][v]], weight);
      }
      for (const auto& [v, at] : local[s]) fit.add(patch.uv[at], region.chart.uv[index(v)], anchor);
      const Eigen::Isometry2d motion = fit.motion();
      for (Vector2d& uv : patch.uv) uv = motion * uv;
    }
}

std::vector<Seam> measured(const Region& region, const std::vector<Segment>& segments, const Borders& seams) {
  std::vector<std::map<int, std::size_t>> local;
  for (const Segment& s : segments) local.push_back(numbering(region.chart, s));
  std::vector<Seam> out;
  for (const auto& [key, border] : seams) {
    Seam seam{key.first, key.second, border.mm, 0, 0, Vector3d::Zero()};
    const auto a = index(key.first), b = index(key.second);
    Vector3d middle = Vector3d::Zero();
    for (const auto& [v, weight] : border.vertices) {
      const double jump = (segments[a].patch.uv[local[a][v]] - segments[b].patch.uv[local[b][v]]).norm();
      seam.mean_jump_mm += weight * jump / border.mm;
      seam.max_jump_mm = std::max(seam.max_jump_mm, jump);
      middle += weight * region.chart.inked[index(v)] / border.mm;
    }
    const auto nearest =
        std::min_element(border.vertices.begin(), border.vertices.end(), [&](const auto& p, const auto& q) {
          return (region.chart.inked[index(p.first)] - middle).norm() <
                 (region.chart.inked[index(q.first)] - middle).norm();
        });
    seam.place = region.chart.inked[index(nearest->first)];
    out.push_back(seam);
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
    const double s1 = std::sqrt(half + root), s2 = det > 0 ? det / s1 : 0;  // turned over: as bad as can be
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

Result<Segments> cut_into_segments(const Patch& chart, double scale, double limit, const Context& context) {
  const Region region(chart);
  VACUFORM_TRY(segments, cut(region, scale, limit, context));
  VACUFORM_CHECK(join(region, segments, scale, limit, context));
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.faces.front() < b.faces.front(); });
  const Borders seams = borders(region, segments);
  stitch(region, segments, seams);
  Segments out;
  out.seams = measured(region, segments, seams);
  for (Segment& s : segments) {
    out.patches.push_back(std::move(s.patch));
    out.distortion.push_back(s.distortion);
  }
  return out;
}

}  // namespace vacuform
