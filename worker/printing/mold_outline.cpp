#include "worker/printing/mold_outline.hpp"

#include <algorithm>
#include <cmath>

#include "worker/pattern/even_points.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Ring = std::vector<Vector2d>;
constexpr double most_moved_cells = 0.75;  // steps go no farther from the line; corners of the mold stay
constexpr double clear_mm = 2, point_mm = 1, shortest_mm = 4;
constexpr double smoothed_cells =
    4;  // standard deviation along the line: steps of a shallow slope are cells apart

Ring evenly(const Ring& ring) {
  double length = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) length += (ring[(i + 1) % ring.size()] - ring[i]).norm();
  return even_points(ring, std::max(8, static_cast<int>(std::lround(length / point_mm))));
}

Ring blurred(const Ring& ring, double deviation) {
  const int n = static_cast<int>(ring.size()),
            reach = std::min(n / 2, static_cast<int>(std::ceil(3 * deviation)));
  std::vector<double> weights;
  double total = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (deviation * deviation)));
    total += weights.back();
  }
  Ring out(ring.size(), Vector2d(0, 0));
  for (int i = 0; i < n; ++i)
    for (int k = -reach; k <= reach; ++k) out[i] += weights[k + reach] / total * ring[((i + k) % n + n) % n];
  return out;
}

Vector2d within(const Vector2d& move, double most) {
  const double length = move.norm();
  return length > most ? Vector2d(most / length * move) : move;
}

// A blur alone would shrink the ring by its curvature; what a second blur removes is added back (Taubin 1995).
Ring smooth(const Ring& ring, double grid_mm) {
  Ring even = evenly(ring);
  const double deviation =
      std::min(smoothed_cells * grid_mm / point_mm, static_cast<double>(even.size()) / 12);
  const Ring once = blurred(even, deviation), twice = blurred(once, deviation);
  for (std::size_t i = 0; i < even.size(); ++i)
    even[i] += within(2 * once[i] - twice[i] - even[i], most_moved_cells * grid_mm);
  return even;
}

double length_of(const Ring& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

}  // namespace

std::vector<Line> mold_outline(const std::vector<Ring>& rings, double grid_mm, const LaidInk& ink) {
  std::vector<Line> lines;
  for (const Ring& given : rings) {
    if (given.size() < 3) continue;
    const Ring ring = smooth(given, grid_mm);
    const std::size_t n = ring.size();
    std::vector<bool> clear;
    for (const Vector2d& p : ring) clear.push_back(!ink.any_near(p, clear_mm));
    const auto gap = std::find(clear.begin(), clear.end(), false);
    if (gap == clear.end()) {
      lines.push_back({.points = ring, .closed = true, .dashed = true});
      continue;
    }
    // Starts at the gap and runs around to it again.
    const auto first = static_cast<std::size_t>(gap - clear.begin());
    Ring piece;
    for (std::size_t i = 1; i <= n; ++i) {
      const std::size_t at = (first + i) % n;
      if (clear[at]) {
        piece.push_back(ring[at]);
        continue;
      }
      if (length_of(piece) >= shortest_mm) lines.push_back({.points = piece, .dashed = true});
      piece.clear();
    }
  }
  return lines;
}

}  // namespace vacuform
