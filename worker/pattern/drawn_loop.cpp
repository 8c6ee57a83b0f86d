#include "worker/pattern/drawn_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "worker/numerics/plane.hpp"
#include "worker/pattern/clipping.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Polyline = std::vector<Vector2d>;

constexpr double most_gap = 0.15, most_gaps = 0.25, least_roundness = 0.25;  // of the way round; of a circle
constexpr double same_mm = 1e-6;
constexpr std::size_t most_lines = 4096, most_outline_points = 2048;
constexpr double ring_pieces = 720;

double length(const Polyline& line) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) sum += (line[i + 1] - line[i]).norm();
  return sum;
}

Vector2d nearest(const Vector2d& p, const Polyline& line, bool closed = true) {
  Vector2d best = line.front();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + (closed ? 0 : 1) < line.size(); ++i) {
    const Vector2d &a = line[i], ab = line[(i + 1) % line.size()] - a;
    const double square = ab.squaredNorm();
    const Vector2d q = square > 0 ? Vector2d(a + std::clamp((p - a).dot(ab) / square, 0.0, 1.0) * ab) : a;
    if (const double d = (p - q).squaredNorm(); d < least) least = d, best = q;
  }
  return best;
}

// Adds points, so that none lies farther than `step` from the next.
Polyline densified(const Polyline& ring, double step) {
  Polyline out;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    for (int k = 0; k < pieces; ++k) out.push_back(a + (b - a) * k / pieces);
  }
  return out;
}

Polyline without_repeats(const Polyline& line) {
  Polyline out;
  for (const Vector2d& p : line)
    if (out.empty() || (p - out.back()).norm() > same_mm) out.push_back(p);
  while (out.size() > 1 && (out.front() - out.back()).norm() <= same_mm) out.pop_back();
  return out;
}

// Of an outline with too many points, as many as are examined, evenly.
Ring thinned(const Ring& ring) {
  const std::size_t stride = 1 + (ring.size() - 1) / most_outline_points;
  Ring out;
  for (std::size_t i = 0; i < ring.size(); i += stride) out.push_back(ring[i]);
  return out;
}

double equal_radius(const Polyline& ring) { return std::sqrt(std::abs(signed_area(ring)) / M_PI); }

// The end of an open line: 2 i is the beginning of line i, 2 i + 1 its other end.
struct End {
  Vector2d at, outward;
};

// How ends are joined: each with the one that it leads to.
class Joints {
 public:
  explicit Joints(const std::vector<const LoopLine*>& lines) : partner_(2 * lines.size(), none) {
    std::vector<double> lengths;
    for (const LoopLine* line : lines) {
      lengths.push_back(length(line->points));
      const Polyline& p = line->points;
      // The direction over a tenth of a line, or so: the last chord of a curve says little.
      const double near = std::min(0.1 * lengths.back(), std::max(line->width_mm, 0.5));
      std::size_t first = 1, last = p.size() - 2;
      while (first + 1 < p.size() && (p[first] - p.front()).norm() < near) ++first;
      while (last > 0 && (p[last] - p.back()).norm() < near) --last;
      ends_.push_back({p.front(), (p.front() - p[first]).normalized()});
      ends_.push_back({p.back(), (p.back() - p[last]).normalized()});
    }
    find(lines, lengths);
  }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::size_t partner(std::size_t end) const { return partner_[end]; }

 private:
  struct Candidate {
    double cost;
    std::size_t a, b;
  };

  void find(const std::vector<const LoopLine*>& lines, const std::vector<double>& lengths) {
    // By x, so that only what is near is compared.
    std::vector<std::size_t> order(ends_.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(ends_[a].at.x(), a) < std::pair(ends_[b].at.x(), b);
    });
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    std::vector<Candidate> candidates;
    constexpr std::size_t most_each = 16;  // of an end
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::vector<Candidate> own;
      for (std::size_t j = i + 1; j < order.size(); ++j) {
        const std::size_t a = order[i], b = order[j];
        if (ends_[b].at.x() - ends_[a].at.x() > longest) break;
        // Not more than two lines and their gaps can be: each gap is at most 15 % of the whole.
        const double both = a / 2 == b / 2 ? 0.25 * lengths[a / 2] : lengths[a / 2] + lengths[b / 2];
        const Vector2d gap = ends_[b].at - ends_[a].at;
        if (gap.norm() > both) continue;
        own.push_back({cost(gap, ends_[a], ends_[b], std::max(lines[a / 2]->width_mm, 1e-3)), a, b});
        if (own.size() < 4 * most_each) continue;
        keep_best(own, most_each);
      }
      keep_best(own, most_each);
      candidates.insert(candidates.end(), own.begin(), own.end());
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& p, const Candidate& q) {
      return std::tie(p.cost, p.a, p.b) < std::tie(q.cost, q.a, q.b);
    });
    for (const Candidate& c : candidates)
      if (partner_[c.a] == none && partner_[c.b] == none) partner_[c.a] = c.b, partner_[c.b] = c.a;
  }

  static void keep_best(std::vector<Candidate>& own, std::size_t most) {
    std::sort(own.begin(), own.end(), [](const Candidate& p, const Candidate& q) {
      return std::tie(p.cost, p.b) < std::tie(q.cost, q.b);
    });
    if (own.size() > most) own.resize(most);
  }

  // A gap counts more the less it lies ahead of its two ends.
  static double cost(const Vector2d& gap, const End& a, const End& b, double width) {
    const double mm = gap.norm();
    double aside = 0;
    if (mm > 0.1 * width)
      aside = 2 - a.outward.dot(gap) / mm + b.outward.dot(gap) / mm;
    else
      aside = 1 + a.outward.dot(b.outward);
    return (mm + 0.05 * width) * (1 + 8 * aside);
  }

  std::vector<End> ends_;
  std::vector<std::size_t> partner_;
};

// A line as part of a row, which may run backwards.
struct RowLine {
  std::size_t line;  // of those given
  const LoopLine* points;
  bool backwards;
  Vector2d begin() const { return backwards ? points->points.back() : points->points.front(); }
  Vector2d end() const { return backwards ? points->points.front() : points->points.back(); }
};

// Without leads: less than half of the row that comes back to about where it began.
void drop_spurs(std::vector<RowLine>& row) {
  constexpr double comes_back = 0.25;  // of its length
  constexpr std::size_t most = 256;
  if (row.size() > most) return;
  for (bool again = true; again;) {
    again = false;
    const std::size_t n = row.size();
    double whole = 0, longest = 0;
    for (const RowLine& part : row) whole += length(part.points->points);
    std::size_t best = 0, parts = 0;
    for (std::size_t first = 0; first < n; ++first) {
      double mm = 0;
      for (std::size_t count = 1; count < n; ++count) {
        const RowLine& last = row[(first + count - 1) % n];
        mm += length(last.points->points);
        if (mm > whole / 2) break;
        const double apart = (row[first].begin() - last.end()).norm();
        if (count > 1 && mm > longest && apart < comes_back * mm) longest = mm, best = first, parts = count;
      }
    }
    if (parts == 0) return;
    std::rotate(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(best), row.end());
    row.erase(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(parts));
    again = true;
  }
}

// The lines of one cycle of joints, closed.
std::optional<DrawnLoop> closed_row(const std::vector<RowLine>& row) {
  DrawnLoop out;
  double drawn = 0, gaps = 0, widest_gap = 0, by_width = 0;
  for (const RowLine& part : row) {
    const Polyline& points = part.points->points;
    if (part.backwards)
      out.line.insert(out.line.end(), points.rbegin(), points.rend());
    else
      out.line.insert(out.line.end(), points.begin(), points.end());
    const double mm = length(points);
    drawn += mm, by_width += part.points->width_mm * mm;
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double gap = (row[i].end() - row[(i + 1) % row.size()].begin()).norm();
    gaps += gap, widest_gap = std::max(widest_gap, gap);
  }
  const double around = drawn + gaps;
  if (!(drawn > 0) || widest_gap > most_gap * around || gaps > most_gaps * around) return {};
  out.line = without_repeats(out.line);
  out.area_mm2 = lobes_area(out.line);
  out.width_mm = by_width / drawn;
  if (4 * M_PI * out.area_mm2 < least_roundness * around * around) return {};
  if (out.area_mm2 < 0.5 * around * out.width_mm) return {};
  return out;
}

}  // namespace

double signed_area(const std::vector<Vector2d>& line) {
  double twice = 0;
  for (std::size_t i = 0; i < line.size(); ++i) twice += cross(line[i], line[(i + 1) % line.size()]);
  return twice / 2;
}

LoopLine loop_line(const Curve& curve, double width_mm) {
  LoopLine out{{}, curve.closed, width_mm};
  for (const CurvePoint& point : flatten(curve, {})) out.points.push_back(point.at);
  if (curve.closed && !out.points.empty()) out.points.pop_back();
  return out;
}

double lobes_area(const Polyline& line) { return square_mm(covered_by({line}, FillRule::even_odd)); }

bool is_inside(const Vector2d& p, const Polyline& ring) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      inside = !inside;
  }
  return inside;
}

std::optional<DrawnLoop> closed_loop(const LoopLine& line) {
  const Polyline points = without_repeats(line.points);
  if (!line.closed || points.size() < 3) return {};
  DrawnLoop out{.line = points, .width_mm = line.width_mm, .area_mm2 = lobes_area(points)};
  const double around = length(points) + (points.front() - points.back()).norm();
  // The inner edge must be left.
  if (!(out.area_mm2 > 0.5 * around * line.width_mm)) return {};
  return out;
}

std::vector<GappedLoop> gapped_loops(const std::vector<LoopLine>& lines) {
  std::vector<std::size_t> open;  // longest first
  std::vector<double> lengths;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    lengths.push_back(lines[i].closed ? 0 : length(lines[i].points));
    if (lengths.back() > same_mm) open.push_back(i);
  }
  std::stable_sort(open.begin(), open.end(),
                   [&](std::size_t a, std::size_t b) { return lengths[a] > lengths[b]; });
  if (open.size() > most_lines) open.resize(most_lines);
  std::sort(open.begin(), open.end());
  std::vector<GappedLoop> out;
  if (open.empty()) return out;
  std::vector<const LoopLine*> given;
  for (const std::size_t i : open) given.push_back(&lines[i]);
  const Joints joints(given);
  std::vector<char> seen(given.size());
  for (std::size_t first = 0; first < given.size(); ++first) {
    if (seen[first]) continue;
    std::vector<RowLine> row;
    std::size_t end = 2 * first + 1, next = Joints::none;  // the row goes on from `end`
    for (;; end = next ^ 1u) {
      seen[end / 2] = 1;
      row.push_back({open[end / 2], given[end / 2], end % 2 == 0});
      next = joints.partner(end);
      if (next == Joints::none || seen[next / 2]) break;
    }
    if (next != 2 * first) {  // an open row, and what comes before its first line is of the same
      for (std::size_t back = joints.partner(2 * first); back != Joints::none && !seen[back / 2];
           back = joints.partner(back ^ 1u))
        seen[back / 2] = 1;
      continue;
    }
    drop_spurs(row);
    auto loop = closed_row(row);
    if (!loop) continue;
    GappedLoop found{std::move(*loop), {}};
    for (const RowLine& part : row) found.lines.push_back(part.line);
    std::sort(found.lines.begin(), found.lines.end());
    out.push_back(std::move(found));
  }
  return out;
}

std::optional<DrawnLoop> filled_ring(const Area& outlines) {
  const auto smaller = [](const Ring& a, const Ring& b) {
    return std::abs(signed_area(a)) < std::abs(signed_area(b));
  };
  const auto largest = std::max_element(outlines.begin(), outlines.end(), smaller);
  if (largest == outlines.end() || largest->size() < 3) return {};
  const Ring* hole = nullptr;
  for (const Ring& ring : outlines)
    if (&ring != &*largest && ring.size() > 2 && is_inside(ring.front(), *largest) &&
        (!hole || smaller(*hole, ring)))
      hole = &ring;
  if (!hole || equal_radius(*hole) <= 0.5 * equal_radius(*largest)) return {};
  const Ring outer = thinned(*largest), inner = thinned(*hole);
  DrawnLoop out;
  out.filled = true;
  double least = std::numeric_limits<double>::infinity(), most = 0;
  Polyline around = outer;
  around.push_back(outer.front());
  for (const Vector2d& p : densified(outer, length(around) / ring_pieces)) {
    const Vector2d q = nearest(p, inner);
    const double width = (p - q).norm();
    least = std::min(least, width), most = std::max(most, width);
    out.line.push_back((p + q) / 2);
  }
  out.line = without_repeats(out.line);
  out.area_mm2 = std::abs(signed_area(out.line));
  Polyline middle = out.line;
  middle.push_back(out.line.front());
  out.width_mm = (std::abs(signed_area(outer)) - std::abs(signed_area(inner))) / length(middle);
  if (!(least >= 0.5 * out.width_mm) || most > 2 * out.width_mm) return {};
  return out;
}

std::optional<LoopLine> filled_band(const Area& outlines) {
  if (outlines.size() != 1 || outlines[0].size() < 4) return {};
  const Ring outline = thinned(outlines[0]);
  Polyline around = outline;
  around.push_back(outline.front());
  const double perimeter = length(around), area = std::abs(signed_area(outline));
  // Of a band: perimeter = 2 (long + wide), area = long wide.
  const double root = perimeter * perimeter / 16 - area;
  if (!(root > 0)) return {};
  const double wide = perimeter / 4 - std::sqrt(root), far = perimeter / 2 - wide;
  if (!(wide > 0) || far < 5 * wide) return {};
  const double step = std::max(wide / 8, perimeter / 4096);
  const Polyline points = densified(outline, step);
  const auto n = static_cast<std::ptrdiff_t>(points.size());
  const auto at = [&](std::ptrdiff_t i) -> const Vector2d& { return points[((i % n) + n) % n]; };
  // The ends are where the outline comes back to itself within about a width.
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(1.5 * wide / step));
  if (2 * reach >= n / 4) return {};
  const auto turned_back = [&](std::ptrdiff_t i) {
    const Vector2d into = at(i - reach) - at(i - 2 * reach), out = at(i + 2 * reach) - at(i + reach);
    return -into.dot(out) / std::max(1e-12, into.norm() * out.norm());
  };
  const auto best = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
    std::ptrdiff_t out = from;
    double least = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t i = from; i < to; ++i) {
      if (turned_back(i) < 0.7) continue;
      const double narrow = (at(i - reach) - at(i + reach)).norm();
      if (narrow < least) least = narrow, out = i;
    }
    return std::isfinite(least) && least < 2 * wide ? std::optional(out) : std::nullopt;
  };
  const auto one = best(0, n);
  if (!one) return {};
  const auto other = best(*one + n / 4, *one + n - n / 4);
  if (!other) return {};
  Polyline left, right;
  for (std::ptrdiff_t i = *one; i <= *other; ++i) left.push_back(at(i));
  for (std::ptrdiff_t i = *one + n; i >= *other; --i) right.push_back(at(i));
  const auto trim = static_cast<std::size_t>(std::ceil(0.5 * wide / step));
  if (left.size() < 2 * trim + 4 || right.size() < 4) return {};
  LoopLine out{{}, false, wide};
  const std::size_t stride = std::max<std::size_t>(1, left.size() / 360);
  for (std::size_t i = trim; i + trim < left.size(); i += stride) {
    const Vector2d q = nearest(left[i], right, false);
    const double width = (left[i] - q).norm();
    if (width > 2 * wide) return {};
    out.points.push_back((left[i] + q) / 2);
  }
  return out;
}

}  // namespace vacuform
