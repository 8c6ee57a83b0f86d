#include "worker/pattern/coil_grid.hpp"

#include <algorithm>
#include <cmath>

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr double nearly_mm = 0.25;  // what lies this near to a trace touches it

}  // namespace

CoilGrid::CoilGrid(const AlignedBox2d& box) : low_(box.min() - Vector2d::Constant(2)) {
  const Vector2d size = box.sizes() + Vector2d::Constant(4);
  step_ = std::max(0.25, std::sqrt(size.prod() / 4e6));
  columns_ = static_cast<int>(size.x() / step_) + 1;
  rows_ = static_cast<int>(size.y() / step_) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
}

void CoilGrid::add(int coil, const DrawnLoop& loop, const Vector2d& centre) {
  add_trace(coil, loop);
  add_inside(coil, loop, centre);
}

std::array<int, 2> CoilGrid::touched(const Vector2d& at) const {
  const Cell* cell = find(at);
  return cell ? cell->trace : std::array{none, none};
}

int CoilGrid::inside(const Vector2d& at) const {
  const Cell* cell = find(at);
  return cell ? cell->inside : none;
}

const CoilGrid::Cell* CoilGrid::find(const Vector2d& at) const {
  const Vector2d c = (at - low_) / step_;
  if (!(c.minCoeff() >= 0 && c.x() < columns_ && c.y() < rows_)) return nullptr;
  return &cells_[index_of(static_cast<int>(c.x()), static_cast<int>(c.y()))];
}

std::size_t CoilGrid::index_of(int x, int y) const {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
}

void CoilGrid::add_trace(int coil, const DrawnLoop& loop) {
  const double reach = loop.width_mm / 2 + std::max(nearly_mm, 0.75 * step_);
  const auto cell_of = [&](double mm, double low, int last) {
    return std::clamp(static_cast<int>((mm - low) / step_), 0, last);
  };
  for (std::size_t i = 0; i < loop.line.size(); ++i) {
    const Vector2d &a = loop.line[i], &b = loop.line[(i + 1) % loop.line.size()], ab = b - a;
    const Vector2d least = a.cwiseMin(b).array() - reach, most = a.cwiseMax(b).array() + reach;
    const int right = cell_of(most.x(), low_.x(), columns_ - 1), top = cell_of(most.y(), low_.y(), rows_ - 1);
    for (int y = cell_of(least.y(), low_.y(), rows_ - 1); y <= top; ++y)
      for (int x = cell_of(least.x(), low_.x(), columns_ - 1); x <= right; ++x) {
        const Vector2d p = middle(x, y) - a;
        const double square = ab.squaredNorm();
        const double t = square > 0 ? std::clamp(p.dot(ab) / square, 0.0, 1.0) : 0;
        if ((p - t * ab).norm() > reach) continue;
        auto& trace = cells_[index_of(x, y)].trace;
        if (trace[0] == coil || trace[1] == coil) continue;
        (trace[0] == none ? trace[0] : trace[1]) = coil;
      }
  }
}

void CoilGrid::add_inside(int coil, const DrawnLoop& loop, const Vector2d& centre) {
  const std::vector<Vector2d>& line = loop.line;
  const double radius = std::sqrt(loop.area_mm2 / M_PI);
  AlignedBox2d box;
  for (const Vector2d& p : line) box.extend(p);
  std::vector<double> crossings;
  const int top = std::min(rows_ - 1, static_cast<int>((box.max().y() - low_.y()) / step_));
  for (int y = std::max(0, static_cast<int>((box.min().y() - low_.y()) / step_)); y <= top; ++y) {
    const double level = middle(0, y).y();
    crossings.clear();
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
      if ((a.y() > level) != (b.y() > level))
        crossings.push_back(a.x() + (b.x() - a.x()) * (level - a.y()) / (b.y() - a.y()));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const int last = std::min(columns_ - 1, static_cast<int>((crossings[k + 1] - low_.x()) / step_));
      for (int x = std::max(0, static_cast<int>((crossings[k] - low_.x()) / step_)); x <= last; ++x) {
        Cell& cell = cells_[index_of(x, y)];
        const auto off = static_cast<float>((middle(x, y) - centre).norm() / radius);
        if (cell.inside == none || off < cell.off) cell.inside = coil, cell.off = off;
      }
    }
  }
}

}  // namespace vacuform
