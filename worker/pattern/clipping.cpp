// Polygon clipping: A. Johnson's Clipper, after B. Vatti 1992, "A generic solution to polygon clipping". Its
// sweep looks, at the height of each point, at every edge that crosses this height, so its time grows with
// the square of a drawing's width. Large polygons are therefore cut in two at a vertical line (Sutherland and
// Hodgman 1974, "Reentrant polygon clipping", which keeps winding numbers on each side), again and again, and
// the results are joined along these lines.
#include "worker/pattern/clipping.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <polyclipping/clipper.hpp>
#include <utility>

namespace vacuform {

namespace {

namespace clip = ClipperLib;
using clip::cInt;
using clip::IntPoint;
using clip::Path;
using clip::Paths;

constexpr double units_per_mm = 1e5;
constexpr std::size_t most_at_once = 10'000;  // points that the library gets at once
constexpr int most_cuts = 24;                 // nested

Paths to_clipper(const std::vector<Ring>& rings) {
  Paths out;
  out.reserve(rings.size());
  for (const Ring& ring : rings) {
    Path& path = out.emplace_back();
    path.reserve(ring.size());
    for (const Eigen::Vector2d& p : ring)
      path.emplace_back(std::llround(p.x() * units_per_mm), std::llround(p.y() * units_per_mm));
  }
  return out;
}

std::vector<Eigen::Vector2d> from_clipper(const Path& path) {
  std::vector<Eigen::Vector2d> out;
  out.reserve(path.size());
  for (const IntPoint& p : path)
    out.emplace_back(static_cast<double>(p.X) / units_per_mm, static_cast<double>(p.Y) / units_per_mm);
  return out;
}

Area from_clipper(Paths paths) {
  // Rounding leaves edges of a few units, which point anywhere.
  clip::CleanPolygons(paths, 0.0005 * units_per_mm);
  Area out;
  for (const Path& path : paths) {
    if (path.size() < 3) continue;
    out.push_back(from_clipper(path));
  }
  return out;
}

std::size_t count_points(const Paths& paths) {
  std::size_t count = 0;
  for (const Path& path : paths) count += path.size();
  return count;
}

// The height at which the edge crosses the line, the same in both directions of the edge.
cInt height_at(cInt x, IntPoint a, IntPoint b) {
  if (a.X > b.X) std::swap(a, b);
  const double f = static_cast<double>(x - a.X) / static_cast<double>(b.X - a.X);
  return a.Y + std::llround(f * static_cast<double>(b.Y - a.Y));
}

enum class Side { left, right };

// The part of the ring on one side of the line; points beyond it are moved onto the line.
Path on_side(const Path& ring, cInt x, Side side) {
  const auto inside = [&](const IntPoint& p) { return side == Side::left ? p.X <= x : p.X >= x; };
  Path out;
  const auto add = [&](const IntPoint& p) {
    if (out.empty() || out.back() != p) out.push_back(p);
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const IntPoint &a = ring[i], &b = ring[i + 1 < ring.size() ? i + 1 : 0];
    if (inside(a)) add(a);
    if ((a.X < x && b.X > x) || (a.X > x && b.X < x)) add({x, height_at(x, a, b)});
  }
  while (out.size() > 1 && out.front() == out.back()) out.pop_back();
  return out;
}

Paths on_side(const Paths& rings, cInt x, Side side) {
  Paths out;
  for (const Path& ring : rings)
    if (Path part = on_side(ring, x, side); part.size() > 2) out.push_back(std::move(part));
  return out;
}

// Joins the results of the two sides of a vertical line.
class Seam {
 public:
  explicit Seam(cInt x) : x_(x) {}

  // Takes the ring apart where it runs along the line.
  void add(Path ring) {
    const std::size_t n = ring.size();
    const auto along = [&](std::size_t i) { return ring[i % n].X == x_ && ring[(i + 1) % n].X == x_; };
    std::size_t first = 0;
    while (first < n && !along(first)) ++first;
    if (first == n) {
      rings_.push_back(std::move(ring));
      return;
    }
    Path chain;
    for (std::size_t i = first; i < first + n; ++i) {
      const IntPoint &a = ring[i % n], &b = ring[(i + 1) % n];
      if (!along(i)) {
        if (chain.empty()) chain.push_back(a);
        chain.push_back(b);
        continue;
      }
      end(chain);
      ++net_upward_[a.Y];
      --net_upward_[b.Y];
    }
    end(chain);
  }

  Paths joined() {
    add_unmatched();
    std::multimap<cInt, std::size_t> from;
    for (std::size_t i = 0; i < chains_.size(); ++i) from.emplace(chains_[i].front().Y, i);
    while (!from.empty()) {
      Path ring;
      const cInt start = from.begin()->first;
      cInt at = start;
      do {
        const auto next = from.find(at);
        if (next == from.end()) break;
        const Path& chain = chains_[next->second];
        ring.insert(ring.end(), chain.begin(), chain.end() - 1);
        at = chain.back().Y;
        from.erase(next);
      } while (at != start);
      if (ring.size() > 2) rings_.push_back(std::move(ring));
    }
    return std::move(rings_);
  }

 private:
  void end(Path& chain) {
    if (!chain.empty()) chains_.push_back(std::move(chain));
    chain = Path();
  }

  // Where both sides run along the line in opposite directions, the line vanishes. Where rounding has left
  // them a unit apart, the rest stays.
  void add_unmatched() {
    int net = 0;
    for (auto at = net_upward_.begin(); at != net_upward_.end(); ++at) {
      net += at->second;
      const auto next = std::next(at);
      for (int i = 0; i < std::abs(net) && next != net_upward_.end(); ++i)
        chains_.push_back(net > 0 ? Path{{x_, at->first}, {x_, next->first}}
                                  : Path{{x_, next->first}, {x_, at->first}});
    }
  }

  const cInt x_;
  Paths rings_, chains_;  // rings that are whole; the others' parts between points on the line
  std::map<cInt, int>
      net_upward_;  // by height: the change in how many rings run upwards, less those that run downwards
};

struct Operation {
  clip::ClipType type;
  clip::PolyFillType rule;
};

Paths at_once(const Operation& operation, const Paths& subject, const Paths& other) {
  clip::Clipper clipper;
  clipper.AddPaths(subject, clip::ptSubject, true);
  clipper.AddPaths(other, clip::ptClip, true);
  Paths out;
  clipper.Execute(operation.type, out, operation.rule, clip::pftNonZero);
  return out;
}

// The middle of the points' x.
cInt middle(const Paths& subject, const Paths& other) {
  std::vector<cInt> all;
  all.reserve(count_points(subject) + count_points(other));
  for (const Paths* paths : {&subject, &other})
    for (const Path& path : *paths)
      for (const IntPoint& p : path) all.push_back(p.X);
  const auto at = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

Paths in_strips(const Operation& operation, Paths subject, Paths other, int depth) {
  const std::size_t count = count_points(subject) + count_points(other);
  if (count <= most_at_once || depth == most_cuts) return at_once(operation, subject, other);
  const cInt x = middle(subject, other);
  Paths left = on_side(subject, x, Side::left), left_other = on_side(other, x, Side::left);
  Paths right = on_side(subject, x, Side::right), right_other = on_side(other, x, Side::right);
  const std::size_t on_left = count_points(left) + count_points(left_other),
                    on_right = count_points(right) + count_points(right_other);
  // Cutting would only multiply edges that run from side to side.
  if (on_left + on_right > count + count / 2 || std::max(on_left, on_right) > count - count / 8)
    return at_once(operation, subject, other);
  subject = Paths();
  other = Paths();
  Seam seam(x);
  for (Path& ring : in_strips(operation, std::move(left), std::move(left_other), depth + 1))
    seam.add(std::move(ring));
  for (Path& ring : in_strips(operation, std::move(right), std::move(right_other), depth + 1))
    seam.add(std::move(ring));
  return seam.joined();
}

}  // namespace

Area covered_by(const std::vector<Ring>& rings, FillRule rule) {
  const Operation operation{clip::ctUnion, rule == FillRule::even_odd ? clip::pftEvenOdd : clip::pftNonZero};
  return from_clipper(in_strips(operation, to_clipper(rings), {}, 0));
}

Area shared_by(const std::vector<Ring>& a, const std::vector<Ring>& b) {
  return from_clipper(in_strips({clip::ctIntersection, clip::pftNonZero}, to_clipper(a), to_clipper(b), 0));
}

Area remainder_of(const std::vector<Ring>& a, const std::vector<Ring>& b) {
  return from_clipper(in_strips({clip::ctDifference, clip::pftNonZero}, to_clipper(a), to_clipper(b), 0));
}

std::vector<std::vector<Eigen::Vector2d>> line_outside(const std::vector<Eigen::Vector2d>& line,
                                                       const std::vector<Ring>& rings) {
  clip::Clipper clipper;
  clipper.AddPaths(to_clipper({line}), clip::ptSubject, false);
  clipper.AddPaths(to_clipper(rings), clip::ptClip, true);
  clip::PolyTree tree;
  clipper.Execute(clip::ctDifference, tree, clip::pftNonZero, clip::pftNonZero);
  Paths parts;
  clip::OpenPathsFromPolyTree(tree, parts);
  std::vector<std::vector<Eigen::Vector2d>> out;
  for (const Path& part : parts) out.push_back(from_clipper(part));
  return out;
}

}  // namespace vacuform
