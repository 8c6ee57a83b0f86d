#include "worker/conductors/widened.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double load_step_mm = 0.5, average_mm = 6;

double load_at(const Trace& trace, double along, const std::vector<std::array<double, 2>>& ink_stretch) {
  const double ahead = 0.25 / trace.scale();
  constexpr double left_mm = 0.25;
  const auto a = trace.at(along - ahead), b = trace.at(along + ahead), c = trace.at(along, left_mm),
             d = trace.at(along, -left_mm);
  const auto e = trace.rest(along - ahead), f = trace.rest(along + ahead), g = trace.rest(along, left_mm),
             h = trace.rest(along, -left_mm);
  if (!a || !b || !c || !d || !e || !f || !g || !h) return 1;
  const Vector3d formed = *b - *a, formed_left = *c - *d;
  const Vector2d flat = *f - *e, flat_left = *g - *h;
  const double area = std::abs(flat.x() * flat_left.y() - flat.y() * flat_left.x());
  if (!(area > 0)) return 1;
  return formed.cross(formed_left).norm() / area * ink_ratio(ink_stretch, formed.norm() / flat.norm());
}

// Over the neighbours of each on a circle.
std::vector<double> averaged(const std::vector<double>& values, int to_each_side) {
  const int count = static_cast<int>(values.size());
  std::vector<double> out;
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    for (int k = -to_each_side; k <= to_each_side; ++k)
      sum += values[index(((i + k) % count + count) % count)];
    out.push_back(sum / (2 * to_each_side + 1));
  }
  return out;
}

bool lies_in(double along, const std::vector<Interval>& parts, double length) {
  return std::any_of(parts.begin(), parts.end(), [&](const Interval& part) {
    return apart_on_loop(along, part.middle(), length) <= part.length() / 2;
  });
}

}  // namespace

double ink_ratio(const std::vector<std::array<double, 2>>& rows, double stretch) {
  if (rows.empty()) return 1;
  const auto after =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row[0] >= stretch; });
  if (after == rows.begin()) return rows.front()[1];
  if (after == rows.end()) return rows.back()[1];
  const auto &a = *(after - 1), &b = *after;
  return a[1] + (stretch - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
}

std::vector<double> trace_loads(const Trace& trace, const std::vector<std::array<double, 2>>& ink_stretch) {
  const double length = trace.path().length();
  const int count = std::max(16, static_cast<int>(std::ceil(length * trace.scale() / load_step_mm)));
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(load_at(trace, length * i / count, ink_stretch));
  return averaged(out, std::min(static_cast<int>(average_mm / 2 / load_step_mm), (count - 1) / 2));
}

WidenedTrace widened(const Trace& trace, const std::vector<double>& loads, double least,
                     const std::vector<Interval>& kept) {
  WidenedTrace out;
  const LoopPath& path = trace.path();
  const double length = path.length();
  const int count = static_cast<int>(loads.size());
  const auto along = [&](int i) { return length * i / count; };
  std::vector<double> factor;
  double all = 0, less = 0, logarithm = 0;
  for (int i = 0; i < count; ++i) {
    const double load = loads[index(i)];
    factor.push_back(lies_in(along(i), kept, length) ? 1 : std::clamp(load / least, 1.0, WidenedTrace::most));
    out.widest = std::max(out.widest, factor.back());
    all += load, less += load / factor.back(), logarithm += std::log(factor.back()) / count;
  }
  out.mean = std::exp(logarithm);
  out.resistance = less / all * out.mean;

  // From one place that keeps its width to the next, or all the way round.
  const auto wide = [&](int i) { return factor[index(i % count)] > 1; };
  const auto first = std::find(factor.begin(), factor.end(), 1.0);
  const int begin = first == factor.end() ? 0 : static_cast<int>(first - factor.begin());
  const double half = trace.width_mm() / 2 / trace.scale();
  const auto beside = [&](int i, double side) {
    constexpr double step = 0.05;
    const double at = along(i);
    const Vector2d ahead = (path.at(at + step) - path.at(at - step)).normalized();
    return Vector2d(path.at(at) + side * half * factor[index(i % count)] * Vector2d(-ahead.y(), ahead.x()));
  };
  for (int i = begin; i < begin + count;) {
    if (!wide(i)) {
      ++i;
      continue;
    }
    int end = i;
    while (end + 1 <= begin + count && wide(end + 1)) ++end;
    if (end == i) ++end;  // a piece has two ends
    std::vector<Vector2d> ring;
    for (int k = i; k <= end; ++k) ring.push_back(beside(k, 1));
    for (int k = end; k >= i; --k) ring.push_back(beside(k, -1));
    ring.push_back(ring.front());
    Shape& shape = out.added.emplace_back();
    shape.curves = {straight_curve(ring)};
    shape.curves.front().closed = true;
    shape.fill = Colour{};
    i = end + 1;
  }
  return out;
}

}  // namespace vacuform
