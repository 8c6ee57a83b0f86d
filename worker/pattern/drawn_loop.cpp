#include "worker/pattern/drawn_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/numerics/plane.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Polyline = std::vector<Vector2d>;

constexpr double most_gap = 0.15, least_turn = 300 * M_PI / 180, least_roundness = 0.25;
constexpr double shorter_gap = 0.01;  // of the circumference: what a further line must save
constexpr double same_mm = 1e-6;
constexpr std::size_t most_lines = 32, most_outline_points = 2048;
constexpr double ring_pieces = 720;

double length(const Polyline& line) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) sum += (line[i + 1] - line[i]).norm();
  return sum;
}

double angle_at(const Vector2d& middle, const Vector2d& a, const Vector2d& b) {
  const Vector2d p = a - middle, q = b - middle;
  return std::atan2(cross(p, q), p.dot(q));
}

// Open lines joined in a row.
struct Row {
  Polyline line;
  std::vector<std::size_t> joints;  // gaps go from these points to the next ones; the last is the row's end
  double width_length = 0;          // sum of width times length

  void add(const LoopLine& next, bool backwards) {
    if (backwards)
      line.insert(line.end(), next.points.rbegin(), next.points.rend());
    else
      line.insert(line.end(), next.points.begin(), next.points.end());
    joints.push_back(line.size() - 1);
    width_length += next.width_mm * length(next.points);
  }
};

// Always continues with the line whose end is nearest to the end of the row.
Row in_a_row(const std::vector<const LoopLine*>& lines) {
  Row row;
  row.add(*lines[0], false);
  std::vector<bool> used(lines.size());
  for (std::size_t step = 1; step < lines.size(); ++step) {
    std::size_t best = 0;
    bool backwards = false;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < lines.size(); ++i)
      for (const bool end : {false, true}) {
        if (used[i]) continue;
        const double d =
            ((end ? lines[i]->points.back() : lines[i]->points.front()) - row.line.back()).norm();
        if (d < least) least = d, best = i, backwards = end;
      }
    used[best] = true;
    row.add(*lines[best], backwards);
  }
  return row;
}

struct Closed {
  DrawnLoop loop;
  double gap_mm = 0, around_mm = 0;
};
std::optional<Closed> closed(Row row) {
  Closed out;
  const Polyline& line = row.line;
  const auto next = [&](std::size_t i) { return (i + 1) % line.size(); };
  for (const std::size_t joint : row.joints) out.gap_mm += (line[next(joint)] - line[joint]).norm();
  out.around_mm = length(line) + (line.front() - line.back()).norm();
  const double drawn_mm = out.around_mm - out.gap_mm, area = std::abs(signed_area(line));
  if (!(drawn_mm > 0) || out.gap_mm > most_gap * out.around_mm) return {};
  if (4 * M_PI * area < least_roundness * out.around_mm * out.around_mm) return {};
  Vector2d middle(0, 0);  // of the line, so that it does not depend on where its points lie
  for (std::size_t i = 0; i < line.size(); ++i)
    middle += (line[next(i)] - line[i]).norm() / out.around_mm * (line[i] + line[next(i)]) / 2;
  double whole = 0, gaps = 0;
  for (std::size_t i = 0; i < line.size(); ++i) whole += angle_at(middle, line[i], line[next(i)]);
  for (const std::size_t joint : row.joints) gaps += angle_at(middle, line[joint], line[next(joint)]);
  if (std::abs(std::abs(whole) - 2 * M_PI) > 0.01 || !(std::abs(whole - gaps) > least_turn)) return {};
  out.loop = {DrawnLoop::Kind::gapped_line, {}, row.width_length / drawn_mm, area, row.joints.size()};
  out.loop.line = std::move(row.line);
  return out;
}

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

Vector2d nearest(const Vector2d& p, const Polyline& ring) {
  Vector2d best = ring.front();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], ab = ring[(i + 1) % ring.size()] - a;
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

double equal_radius(const Polyline& ring) { return std::sqrt(std::abs(signed_area(ring)) / M_PI); }

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

std::optional<DrawnLoop> closed_line(const std::vector<LoopLine>& lines) {
  std::optional<DrawnLoop> out;
  double most = 0;
  for (const LoopLine& line : lines)
    if (const double area = line.closed ? std::abs(signed_area(line.points)) : 0; area > most) {
      most = area;
      out = DrawnLoop{DrawnLoop::Kind::closed_line, line.points, line.width_mm, area, 1};
    }
  return out;
}

std::optional<DrawnLoop> gapped_line(const std::vector<LoopLine>& lines) {
  std::vector<const LoopLine*> open;  // longest first
  for (const LoopLine& line : lines)
    if (!line.closed && line.points.size() > 1) open.push_back(&line);
  std::stable_sort(open.begin(), open.end(), [](const LoopLine* a, const LoopLine* b) {
    return length(a->points) > length(b->points);
  });
  if (open.size() > most_lines) open.resize(most_lines);
  std::optional<Closed> best;
  for (std::size_t count = 1; count <= open.size(); ++count)
    if (auto next = closed(in_a_row({open.begin(), open.begin() + static_cast<std::ptrdiff_t>(count)}));
        next && (!best || next->gap_mm < best->gap_mm - shorter_gap * next->around_mm))
      best = std::move(next);
  if (!best) return {};
  best->loop.line = without_repeats(best->loop.line);
  return std::move(best->loop);
}

std::optional<DrawnLoop> filled_ring(const Area& outlines) {
  const auto smaller = [](const Ring& a, const Ring& b) {
    return std::abs(signed_area(a)) < std::abs(signed_area(b));
  };
  const auto outer = std::max_element(outlines.begin(), outlines.end(), smaller);
  if (outer == outlines.end() || outer->size() > most_outline_points) return {};
  const Ring* inner = nullptr;
  for (const Ring& ring : outlines)
    if (&ring != &*outer && !ring.empty() && is_inside(ring.front(), *outer) &&
        (!inner || smaller(*inner, ring)))
      inner = &ring;
  if (!inner || inner->size() > most_outline_points || equal_radius(*inner) <= 0.5 * equal_radius(*outer))
    return {};
  DrawnLoop out{DrawnLoop::Kind::filled_ring, {}, 0, 0, 1};
  double least = std::numeric_limits<double>::infinity(), most = 0;
  Polyline around = *outer;
  around.push_back(outer->front());
  for (const Vector2d& p : densified(*outer, length(around) / ring_pieces)) {
    const Vector2d q = nearest(p, *inner);
    const double width = (p - q).norm();
    least = std::min(least, width), most = std::max(most, width);
    out.line.push_back((p + q) / 2);
  }
  out.line = without_repeats(out.line);
  out.area_mm2 = std::abs(signed_area(out.line));
  Polyline middle = out.line;
  middle.push_back(out.line.front());
  out.width_mm = (std::abs(signed_area(*outer)) - std::abs(signed_area(*inner))) / length(middle);
  if (!(least >= 0.5 * out.width_mm) || most > 2 * out.width_mm) return {};
  return out;
}

std::optional<DrawnLoop> drawn_loop(const Element& element) {
  std::vector<LoopLine> lines;
  std::optional<DrawnLoop> out;
  const auto take = [&](std::optional<DrawnLoop> loop) {
    if (loop && (!out || loop->area_mm2 > out->area_mm2)) out = std::move(loop);
  };
  for (const Shape& shape : element.shapes) {
    if (shape.stroke)
      for (const Curve& curve : shape.curves) lines.push_back(loop_line(curve, shape.stroke->width_mm));
    else if (shape.fill)
      take(filled_ring(fill_area(shape.curves, shape.even_odd, 0.002)));
  }
  take(gapped_line(lines));
  take(closed_line(lines));
  return out;
}

}  // namespace vacuform
