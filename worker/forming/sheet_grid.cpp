#include "worker/forming/sheet_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace vacuform {

namespace {

// Lines from -outer to outer with a line exactly at each of -inner and inner; an even number of cells inside.
std::vector<double> lines(double outer, double inner, double spacing) {
  const auto cells = [&](double length) {
    return std::max(0, static_cast<int>(std::ceil(length / spacing - 1e-9)));
  };
  std::vector<double> at;
  const int margin = cells(outer - inner);
  const int middle = 2 * std::max(1, cells(inner));
  for (int k = 0; k < margin; ++k) at.push_back(-outer + (outer - inner) * k / margin);
  for (int k = 0; k <= middle; ++k) at.push_back(inner * (2.0 * k / middle - 1.0));
  for (int k = 1; k <= margin; ++k) at.push_back(inner + (outer - inner) * k / margin);
  return at;
}

// George's nested dissection of the index rectangle [x0, x1) x [y0, y1): halves first, the separating line last.
// Returns the part, or -1 for nothing.
int dissect(int x0, int x1, int y0, int y1, SheetGrid& grid) {
  const int w = x1 - x0, h = y1 - y0;
  if (w <= 0 || h <= 0) return -1;
  constexpr int indivisible = 12;
  Dissection::Part part;
  int own_x0 = x0, own_x1 = x1, own_y0 = y0, own_y1 = y1;
  if (w * h > indivisible && w >= h) {
    own_x0 = x0 + w / 2, own_x1 = own_x0 + 1;
    part.first = dissect(x0, own_x0, y0, y1, grid);
    part.second = dissect(own_x1, x1, y0, y1, grid);
  } else if (w * h > indivisible) {
    own_y0 = y0 + h / 2, own_y1 = own_y0 + 1;
    part.first = dissect(x0, x1, y0, own_y0, grid);
    part.second = dissect(x0, x1, own_y1, y1, grid);
  }
  part.begin = static_cast<int>(grid.elimination_order.size());
  for (int y = own_y0; y < own_y1; ++y)
    for (int x = own_x0; x < own_x1; ++x)
      grid.elimination_order.push_back(y * static_cast<int>(grid.columns.size()) + x);
  part.end = static_cast<int>(grid.elimination_order.size());
  grid.dissection.parts.push_back(part);
  return static_cast<int>(grid.dissection.parts.size()) - 1;
}

// A triangle whose corners all lie on the circle is a sliver: the edge between its two outer corners is turned over
// to the opposite corner of the neighbour. Where that lies on the circle too, the middle corner goes back `home`.
void collapse_sliver(SheetGrid& grid, std::size_t sliver, std::vector<char>& on_circle,
                     const std::vector<Eigen::Vector2d>& home) {
  Triangle& flat = grid.triangles[sliver];
  const auto length = [&](int k) {
    return (grid.rest[flat[k]] - grid.rest[flat[(k + 1) % 3]]).squaredNorm();
  };
  int k = 0;
  for (int other : {1, 2})
    if (length(other) > length(k)) k = other;
  const int a = flat[k], b = flat[(k + 1) % 3], middle = flat[(k + 2) % 3];
  for (Triangle& t : grid.triangles)
    for (int e = 0; e < 3; ++e)
      if (t[e] == b && t[(e + 1) % 3] == a && !on_circle[t[(e + 2) % 3]]) {
        const int opposite = t[(e + 2) % 3];
        t = {middle, opposite, b};
        flat = {middle, a, opposite};
        return;
      }
  on_circle[middle] = 0;
  grid.rest[middle] = home[middle];
}

// Moves, of every edge that crosses the circle, the nearer end onto it, unless an end of it is there already.
void snap_to_circle(SheetGrid& grid, double radius, double spacing) {
  const auto off = [&](int v) { return grid.rest[v].norm() - radius; };
  std::vector<std::pair<double, std::array<int, 2>>>
      crossing;  // distance of the nearer end; nearer end, other end
  for (const Triangle& t : grid.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (off(a) * off(b) >= 0) continue;
      const bool a_nearer = std::abs(off(a)) <= std::abs(off(b));
      crossing.push_back(
          {std::min(std::abs(off(a)), std::abs(off(b))), {a_nearer ? a : b, a_nearer ? b : a}});
    }
  std::sort(crossing.begin(), crossing.end());
  std::vector<char> on_circle;
  for (int v = 0; v < static_cast<int>(grid.rest.size()); ++v)
    on_circle.push_back(std::abs(off(v)) < 0.1 * spacing);
  for (const auto& [distance, edge] : crossing)
    if (!on_circle[edge[0]] && !on_circle[edge[1]]) on_circle[edge[0]] = 1;
  const std::vector<Eigen::Vector2d> home = grid.rest;
  for (std::size_t i = 0; i < on_circle.size(); ++i)
    if (on_circle[i]) grid.rest[i] *= radius / grid.rest[i].norm();
  for (std::size_t k = 0; k < grid.triangles.size(); ++k) {
    const Triangle& t = grid.triangles[k];
    if (on_circle[t[0]] && on_circle[t[1]] && on_circle[t[2]]) collapse_sliver(grid, k, on_circle, home);
  }
}

}  // namespace

SheetGrid make_sheet_grid(const SheetSettings& sheet, const MachineSettings& machine) {
  const bool circle = machine.window == WindowShape::circle;
  const double half_w = machine.window_width_mm / 2;
  const double half_h = circle ? half_w : machine.window_height_mm / 2;
  const auto xs = lines(sheet.width_mm / 2, half_w, sheet.resolution_mm);
  const auto ys = lines(sheet.height_mm / 2, half_h, sheet.resolution_mm);
  const int columns = static_cast<int>(xs.size()), rows = static_cast<int>(ys.size());

  SheetGrid grid;
  grid.columns = xs, grid.rows = ys;
  for (double y : ys)
    for (double x : xs) grid.rest.emplace_back(x, y);
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      const int a = j * columns + i, b = a + 1, c = a + columns + 1, d = a + columns;
      if ((i + j + columns / 2 + rows / 2) % 2 == 0) {  // the same around the centre on every grid
        grid.triangles.push_back({a, b, c});
        grid.triangles.push_back({a, c, d});
      } else {
        grid.triangles.push_back({a, b, d});
        grid.triangles.push_back({b, c, d});
      }
    }
  if (circle) snap_to_circle(grid, half_w, sheet.resolution_mm);

  const double tiny = 1e-9 * (sheet.width_mm + sheet.height_mm);
  for (const auto& p : grid.rest)
    grid.clamped.push_back(circle ? p.norm() >= half_w - tiny
                                  : std::abs(p.x()) >= half_w - tiny || std::abs(p.y()) >= half_h - tiny);
  dissect(0, columns, 0, rows, grid);
  return grid;
}

}  // namespace vacuform
