#include "worker/conductors/crossings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "worker/conductors/loop_path.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double piece_mm = 0.5;  // of points along a loop: a chord lies within 0.002 mm of a circle of 16 mm

// A piece of a loop between two of its points.
struct Piece {
  int coil = 0;             // index into Drawing::elements
  double from = 0, to = 0;  // along the loop
  Vector2d a, b;            // sheet coordinates
  Vector3d p, q;            // in space
};

// The loop as a patch lays it; pieces that run off the patch are left out.
void add_pieces(const LoopPath& path, const Patch& patch, const PlaneLocator& locator, int coil,
                std::vector<Piece>& out) {
  const int count = std::max(3, static_cast<int>(std::ceil(path.length() / piece_mm)));
  std::optional<std::pair<Vector2d, Vector3d>> before;
  for (int i = 0; i <= count; ++i) {
    const double along = path.length() * i / count;
    const auto found = locator.nearest(path.at(i == count ? 0 : along), 1e-3);
    if (!found) {
      before.reset();
      continue;
    }
    const auto at = std::pair(interpolate(patch.triangles, *found, patch.rest),
                              interpolate(patch.triangles, *found, patch.inked));
    if (before)
      out.push_back(
          {coil, path.length() * (i - 1) / count, along, before->first, at.first, before->second, at.second});
    before = at;
  }
}

std::vector<Piece> pieces_of_loops(const Drawing& drawing, const Placement& placement) {
  std::vector<std::vector<Piece>> of_loop(drawing.elements.size());
  const auto has_loop = [&](std::size_t e) {
    const std::optional<DrawnLoop>& loop = drawing.elements[e].loop;
    return loop && loop->line.size() >= 3;
  };
  if (placement.elements.empty()) {
    for (const Segment& chart : placement.charts) {
      const PlaneLocator locator(chart.patch.triangles, chart.patch.uv);
      for (std::size_t e = 0; e < of_loop.size(); ++e)
        if (has_loop(e))
          add_pieces(LoopPath(*drawing.elements[e].loop), chart.patch, locator, static_cast<int>(e),
                     of_loop[e]);
    }
  } else {
    in_parallel(0, static_cast<int>(placement.elements.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        const PlacedElement& placed = placement.elements[index(i)];
        const std::size_t e = index(placed.element);
        if (has_loop(e))
          add_pieces(LoopPath(*drawing.elements[e].loop), placed.patch,
                     PlaneLocator(placed.patch.triangles, placed.patch.uv), placed.element, of_loop[e]);
      }
    });
  }
  std::vector<Piece> out;
  for (const auto& some : of_loop) out.insert(out.end(), some.begin(), some.end());
  return out;
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::optional<Crossing> crossing(const Piece& one, const Piece& other) {
  const Vector2d u = one.b - one.a, v = other.b - other.a, between = other.a - one.a;
  const double area = cross(u, v);
  if (area == 0) return std::nullopt;
  // A piece has its beginning and not its end, so that a crossing at a point of a loop counts once.
  const double x = cross(between, v) / area, y = cross(between, u) / area;
  if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) return std::nullopt;
  const Vector3d p = one.q - one.p, q = other.q - other.p;
  const double sine = p.cross(q).norm() / (p.norm() * q.norm());
  if (!(sine > 1e-6)) return std::nullopt;
  return Crossing{one.coil,
                  other.coil,
                  one.from + x * (one.to - one.from),
                  other.from + y * (other.to - other.from),
                  sine,
                  one.a + x * u,
                  one.p + x * p};
}

// Pieces by the squares of a grid that their boxes meet.
class Squares {
 public:
  using Square = std::pair<std::int64_t, std::int64_t>;

  template <class Use>
  static void each(const Piece& piece, const Use& use) {
    const Vector2d low = piece.a.cwiseMin(piece.b) / size_mm, high = piece.a.cwiseMax(piece.b) / size_mm;
    for (auto x = static_cast<std::int64_t>(std::floor(low.x())); x <= std::floor(high.x()); ++x)
      for (auto y = static_cast<std::int64_t>(std::floor(low.y())); y <= std::floor(high.y()); ++y)
        use(Square(x, y));
  }

 private:
  static constexpr double size_mm = 1;
};

}  // namespace

std::vector<Crossing> crossings(const Drawing& drawing, const Placement& placement) {
  const std::vector<Piece> pieces = pieces_of_loops(drawing, placement);
  std::map<Squares::Square, std::vector<std::size_t>> squares;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    Squares::each(pieces[i], [&](const Squares::Square& square) { squares[square].push_back(i); });
  std::vector<std::pair<std::size_t, std::size_t>> near;
  for (const auto& [square, held] : squares)
    for (std::size_t i = 0; i < held.size(); ++i)
      for (std::size_t k = i + 1; k < held.size(); ++k) {
        const Piece &a = pieces[held[i]], &b = pieces[held[k]];
        if (a.b == b.a || b.b == a.a) continue;  // they follow each other
        near.emplace_back(held[i], held[k]);
      }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<Crossing> out;
  for (const auto& [i, k] : near)
    if (auto found = crossing(pieces[i], pieces[k])) out.push_back(*found);
  std::sort(out.begin(), out.end(), [](const Crossing& x, const Crossing& y) {
    return std::tie(x.a, x.b, x.along_a, x.along_b) < std::tie(y.a, y.b, y.along_a, y.along_b);
  });
  return out;
}

}  // namespace vacuform
