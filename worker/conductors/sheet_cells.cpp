#include "worker/conductors/sheet_cells.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Matrix2d metric_of(const InkedSurface& surface, const Triangle& t) {
  const auto flat = [&](std::size_t k) { return surface.rest()[index(t[k])]; };
  const auto formed = [&](std::size_t k) { return surface.inked()[index(t[k])]; };
  Matrix2d from;
  from << flat(1) - flat(0), flat(2) - flat(0);
  Eigen::Matrix<double, 3, 2> to;
  to << formed(1) - formed(0), formed(2) - formed(0);
  if (!(std::abs(from.determinant()) > 0)) return Matrix2d::Identity();
  const Eigen::Matrix<double, 3, 2> gradient = to * from.inverse();
  return gradient.transpose() * gradient;
}

}  // namespace

SheetCells::SheetCells(const InkedSurface& surface, const Eigen::AlignedBox2d& box)
    : low_(box.min()),
      columns_(std::max(1, static_cast<int>(std::ceil(box.sizes().x() / size_mm)))),
      rows_(std::max(1, static_cast<int>(std::ceil(box.sizes().y() / size_mm)))) {
  for (const Triangle& t : surface.triangles()) metric_.push_back(metric_of(surface, t));
  const PlaneLocator locator(surface.triangles(), surface.rest());
  triangle_.reserve(index(count()));
  for (int cell = 0; cell < count(); ++cell) {
    const auto found = locator.find(middle(cell));
    triangle_.push_back(found ? found->triangle : -1);
  }
}

int SheetCells::at(const Vector2d& rest) const {
  const Vector2d cell = (rest - low_) / size_mm;
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < columns_ && cell.y() < rows_)) return -1;
  return static_cast<int>(cell.y()) * columns_ + static_cast<int>(cell.x());
}

Vector2d SheetCells::middle(int cell) const {
  const int column = cell % columns_, row = cell / columns_;
  return low_ + size_mm * Vector2d(column + 0.5, row + 0.5);
}

std::vector<int> SheetCells::neighbours(int cell) const {
  const int x = cell % columns_, y = cell / columns_;
  std::vector<int> out;
  for (int j = std::max(0, y - 1); j <= std::min(rows_ - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(columns_ - 1, x + 1); ++i)
      if (i != x || j != y) out.push_back(j * columns_ + i);
  return out;
}

double SheetCells::on_part(int cell, const Vector2d& way) const {
  const int t = triangle(cell);
  if (t < 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0.0, way.dot(metric_[index(t)] * way)));
}

void SheetCells::keep_clear(const Disc& disc, Room& room, std::vector<int>& touched) const {
  const int here = at(disc.middle);
  double least = 1;  // stretch
  if (here >= 0 && triangle(here) >= 0) {
    const Eigen::SelfAdjointEigenSolver<Matrix2d> solver(metric_[index(triangle(here))],
                                                         Eigen::EigenvaluesOnly);
    least = std::sqrt(std::clamp(solver.eigenvalues().x(), 0.04, 1.0));
  }
  const Vector2d flat = Vector2d::Constant((disc.radius_mm + disc.reach_mm) / (0.9 * least)),
                 from = (disc.middle - flat - low_) / size_mm, to = (disc.middle + flat - low_) / size_mm;
  for (int y = std::max(0, static_cast<int>(from.y())); y <= std::min(rows_ - 1.0, to.y()); ++y)
    for (int x = std::max(0, static_cast<int>(from.x())); x <= std::min(columns_ - 1.0, to.x()); ++x) {
      const int cell = y * columns_ + x;
      if (triangle(cell) < 0) continue;
      const double mm = on_part(cell, middle(cell) - disc.middle) - disc.radius_mm;
      float& so_far = room[index(cell)];
      if (!(mm < disc.reach_mm) || !(mm < so_far)) continue;
      if (!(so_far < open)) touched.push_back(cell);
      so_far = static_cast<float>(mm);
    }
}

}  // namespace vacuform
