// Charts and formed sheets of known shape, for the tests of flattening.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "worker/flattening/chart.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// A sheet of (2n + 1)^2 vertices, `spacing` apart, formed by `place`, all of it on the mold but a frame of two cells.
inline FormedSheet sheet_of(int n, double spacing,
                            const std::function<Eigen::Vector3d(double, double)>& place) {
  FormedSheet sheet;
  const int side = 2 * n + 1;
  for (int j = -n; j <= n; ++j)
    for (int i = -n; i <= n; ++i) {
      sheet.rest.emplace_back(i * spacing, j * spacing);
      sheet.formed.push_back(place(i * spacing, j * spacing));
      sheet.contact.push_back(std::max(std::abs(i), std::abs(j)) > n - 2 ? Contact::free : Contact::mold);
    }
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i, b = a + 1, c = b + side, d = a + side;
      sheet.triangles.push_back({a, b, c});
      sheet.triangles.push_back({a, c, d});
    }
  sheet.thickness.assign(sheet.rest.size(), 1.0);
  return sheet;
}

// A dome of radius R; the flat sheet within 48 mm of its middle comes to lie on it with a stretch of 1.2 along meridians.
inline FormedSheet dome(double R, int n = 24, double spacing = 2) {
  return sheet_of(n, spacing, [R](double s, double t) {
    const double r = std::hypot(s, t), polar = std::min(1.3, 1.2 * r / R);
    if (r == 0) return Eigen::Vector3d(0, 0, R);
    return Eigen::Vector3d(R * std::sin(polar) * s / r, R * std::sin(polar) * t / r, R * std::cos(polar));
  });
}

inline Mold top_at(const Eigen::Vector3d& top) {
  Mold mold;
  mold.top = top;
  return mold;
}

// A grid of columns x rows cells, placed by `place`, with the flat grid of 1 mm as its start.
inline Chart grid_chart(int columns, int rows, const std::function<Eigen::Vector3d(double, double)>& place) {
  Chart chart;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      chart.uv.emplace_back(i, j);
      chart.inked.push_back(place(i, j));
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, d = a + columns + 1, c = d + 1;
      chart.triangles.push_back({a, b, c});
      chart.triangles.push_back({a, c, d});
    }
  return chart;
}

// A spherical cap of radius 1 down to `polar`, in rings of 6, 12, 18, ... vertices; its start is its shadow.
inline Chart cap(double polar, int rings) {
  Chart chart;
  const auto ring_start = [](int k) { return k == 0 ? 0 : 1 + 3 * k * (k - 1); };
  for (int k = 0; k <= rings; ++k)
    for (int i = 0; i < std::max(1, 6 * k); ++i) {
      const double angle = k == 0 ? 0 : 2 * std::numbers::pi * i / (6 * k), down = polar * k / rings;
      chart.inked.emplace_back(std::sin(down) * std::cos(angle), std::sin(down) * std::sin(angle),
                               std::cos(down));
      chart.uv.push_back(chart.inked.back().head<2>());
    }
  for (int k = 1; k <= rings; ++k)
    for (int sector = 0; sector < 6; ++sector)
      for (int i = 0; i < k; ++i) {
        const auto outer = [&](int j) { return ring_start(k) + (sector * k + j) % (6 * k); };
        const auto inner = [&](int j) {
          return k == 1 ? 0 : ring_start(k - 1) + (sector * (k - 1) + j) % (6 * (k - 1));
        };
        chart.triangles.push_back({outer(i), outer(i + 1), inner(i)});
        if (i + 1 < k) chart.triangles.push_back({inner(i), outer(i + 1), inner(i + 1)});
      }
  return chart;
}

}  // namespace vacuform
