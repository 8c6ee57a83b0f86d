#include "worker/conductors/cheapest_way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double way_step_mm = 0.25;
constexpr double no_way = std::numeric_limits<double>::infinity();

// The cells of the cheapest way, from the first to the one that ends it; empty: none.
std::vector<int> cells_of_way(const SheetCells& cells, const WayCosts& costs, int from,
                              const std::function<bool(int)>& is_end) {
  std::vector<float> least(index(cells.count()), std::numeric_limits<float>::infinity());
  std::vector<int> before(index(cells.count()), -1);
  using Open = std::pair<float, int>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  least[index(from)] = 0;
  open.emplace(0.0F, from);
  while (!open.empty()) {
    const auto [cost, cell] = open.top();
    open.pop();
    if (cost > least[index(cell)]) continue;
    if (is_end(cell)) {
      std::vector<int> way{cell};
      while (before[index(way.back())] >= 0) way.push_back(before[index(way.back())]);
      std::reverse(way.begin(), way.end());
      return way;
    }
    for (const int next : cells.neighbours(cell)) {
      if (!(costs[index(next)] > 0)) continue;
      const double mm = cells.on_part(next, cells.middle(next) - cells.middle(cell));
      const auto sum = static_cast<float>(cost + mm * (costs[index(cell)] + costs[index(next)]) / 2);
      if (sum >= least[index(next)]) continue;
      least[index(next)] = sum;
      before[index(next)] = cell;
      open.emplace(sum, next);
    }
  }
  return {};
}

double cost_of_line(const SheetCells& cells, const WayCosts& costs, const Vector2d& a, const Vector2d& b) {
  const int count = std::max(1, static_cast<int>(std::ceil((b - a).norm() / way_step_mm)));
  const Vector2d step = (b - a) / count;
  double out = 0;
  for (int i = 0; i < count; ++i) {
    const int cell = cells.at(a + (i + 0.5) * step);
    if (cell < 0 || !(costs[index(cell)] > 0)) return no_way;
    out += costs[index(cell)] * cells.on_part(cell, step);
  }
  return out;
}

// Leaves out points as long as the straight line costs no more.
std::vector<Vector2d> straightened(const SheetCells& cells, const WayCosts& costs,
                                   const std::vector<Vector2d>& way) {
  std::vector<double> up_to{0};
  for (std::size_t i = 1; i < way.size(); ++i)
    up_to.push_back(up_to.back() + cost_of_line(cells, costs, way[i - 1], way[i]));
  constexpr std::size_t stride = 3;
  std::vector<Vector2d> out{way.front()};
  for (std::size_t i = 0; i + 1 < way.size();) {
    std::size_t next = i + 1;
    for (std::size_t k = way.size() - 1; k > i + 1; k -= std::min(stride, k - i - 1))
      if (cost_of_line(cells, costs, way[i], way[k]) <= (up_to[k] - up_to[i]) * (1 + 1e-6)) {
        next = k;
        break;
      }
    out.push_back(way[next]);
    i = next;
  }
  return out;
}

// Moves the corners to where the line costs less, as a string that is pulled would.
void pull(const SheetCells& cells, const WayCosts& costs, std::vector<Vector2d>& line) {
  constexpr int most_rounds = 8;
  for (double step = 4; step >= SheetCells::size_mm / 2; step /= 2)
    for (int round = 0; round < most_rounds; ++round) {
      bool better = false;
      for (std::size_t i = 1; i + 1 < line.size(); ++i) {
        const auto cost = [&](const Vector2d& p) {
          return cost_of_line(cells, costs, line[i - 1], p) + cost_of_line(cells, costs, p, line[i + 1]);
        };
        double least = cost(line[i]);
        const Vector2d at = line[i];
        for (int k = 0; k < 8; ++k) {
          const Vector2d p = at + step * Vector2d(std::cos(k * M_PI / 4), std::sin(k * M_PI / 4));
          if (const double moved = cost(p); moved < least * (1 - 1e-6))
            least = moved, line[i] = p, better = true;
        }
      }
      if (!better) break;
    }
}

}  // namespace

std::optional<std::vector<Vector2d>> cheapest_way(const SheetCells& cells, const WayCosts& costs,
                                                  const Vector2d& from,
                                                  const std::function<bool(int)>& is_end) {
  const int first = cells.at(from);
  if (first < 0) return std::nullopt;
  const std::vector<int> found = cells_of_way(cells, costs, first, is_end);
  if (found.empty()) return std::nullopt;
  std::vector<Vector2d> way{from};
  for (std::size_t i = 1; i < found.size(); ++i) way.push_back(cells.middle(found[i]));
  std::vector<Vector2d> line = straightened(cells, costs, way);
  pull(cells, costs, line);
  return straightened(cells, costs, line);
}

std::vector<Vector2d> with_round_corners(
    const std::vector<Vector2d>& line, double radius_mm,
    const std::function<bool(std::size_t corner, const Vector2d&)>& is_free) {
  std::vector<Vector2d> coarse{line.front()};
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const Vector2d in = line[i] - line[i - 1], on = line[i + 1] - line[i];
    const double a = in.norm(), b = on.norm();
    if (!(a > 0) || !(b > 0)) continue;
    const double turn = std::acos(std::clamp(in.dot(on) / a / b, -1.0, 1.0)), half = std::tan(turn / 2);
    double cut = std::min({radius_mm * half, a / 2, b / 2});
    std::vector<Vector2d> arc;
    for (int tries = 0; tries < 5; ++tries, cut /= 2) {
      // A quadratic Bezier curve: within 3 % of the arc up to a right angle.
      arc.clear();
      const Vector2d from = line[i] - cut / a * in, to = line[i] + cut / b * on;
      const int count = std::max(2, static_cast<int>(std::ceil(2 * cut / way_step_mm)));
      for (int k = 0; k <= count; ++k) {
        const double x = static_cast<double>(k) / count;
        arc.push_back((1 - x) * (1 - x) * from + 2 * x * (1 - x) * line[i] + x * x * to);
      }
      if (std::all_of(arc.begin(), arc.end(), [&](const Vector2d& p) { return is_free(i, p); })) break;
    }
    coarse.insert(coarse.end(), arc.begin(), arc.end());
  }
  coarse.push_back(line.back());
  std::vector<Vector2d> out;
  for (std::size_t i = 0; i + 1 < coarse.size(); ++i) {
    const Vector2d way = coarse[i + 1] - coarse[i];
    const int count = std::max(1, static_cast<int>(std::ceil(way.norm() / way_step_mm)));
    if (!(way.norm() > 1e-9)) continue;
    for (int k = 0; k < count; ++k) out.push_back(coarse[i] + way * k / count);
  }
  out.push_back(coarse.back());
  return out;
}

}  // namespace vacuform
