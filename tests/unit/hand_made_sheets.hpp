// Formed sheets of known shape, for the tests of printing and inspection.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "worker/flattening/flattening.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform::hand_made {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Sample {
  Settings settings;
  Mold mold;
  FormedSheet sheet;
  Flattening flattening;
};

// A square sheet of n x n cells with alternating diagonals; nothing formed yet.
inline Sample grid(double side, int n) {
  Sample x;
  x.settings.sheet.width_mm = x.settings.sheet.height_mm = side;
  x.settings.machine.window_width_mm = x.settings.machine.window_height_mm = side - 20;
  FormedSheet& sheet = x.sheet;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      sheet.rest.emplace_back(side * (static_cast<double>(i) / n - 0.5),
                              side * (static_cast<double>(j) / n - 0.5));
      const bool border = i == 0 || j == 0 || i == n || j == n;
      sheet.contact.push_back(border ? Contact::clamp : Contact::platform);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      if ((i + j) % 2 == 0)
        sheet.triangles.insert(sheet.triangles.end(), {Triangle{a, b, d}, Triangle{a, d, c}});
      else
        sheet.triangles.insert(sheet.triangles.end(), {Triangle{a, b, c}, Triangle{b, d, c}});
    }
  const std::size_t vertices = sheet.rest.size(), triangles = sheet.triangles.size();
  for (const auto& st : sheet.rest) sheet.formed.emplace_back(st.x(), st.y(), 0.0);
  sheet.thickness.assign(vertices, 1);
  sheet.temperature.assign(vertices, 130);
  sheet.contact_time.assign(vertices, 0.5);
  sheet.element_thickness.assign(triangles, 1);
  sheet.element_slack.assign(triangles, 0);
  sheet.summary.converged = true;
  x.flattening.chart.assign(vertices, Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  x.flattening.top_rest = Vector2d::Zero();
  x.mold.top = Vector3d::Zero();
  return x;
}

// Makes the triangles whose corners all lie within `radius` (rest, mm) the chart, with `chart` as its
// coordinates.
template <class Chart>
void lay_chart(Sample& x, double radius, Chart&& chart) {
  x.flattening.inked = x.sheet.formed;
  for (std::size_t t = 0; t < x.sheet.triangles.size(); ++t) {
    bool inside = true;
    for (const int v : x.sheet.triangles[t])
      inside &= x.sheet.rest[static_cast<std::size_t>(v)].norm() <= radius;
    if (!inside) continue;
    x.flattening.triangles.push_back(static_cast<int>(t));
    for (const int v : x.sheet.triangles[t])
      x.flattening.chart[static_cast<std::size_t>(v)] = chart(x.sheet.rest[static_cast<std::size_t>(v)]);
  }
}

// A sheet stretched in its own plane by `stretch`; its chart is exact.
inline Sample stretched(double side, int n, const Matrix2d& stretch, double radius = 1e9) {
  Sample x = grid(side, n);
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i)
    x.sheet.formed[i].head<2>() = stretch * x.sheet.rest[i];
  for (auto& h : x.sheet.element_thickness) h = 1 / stretch.determinant();
  for (auto& h : x.sheet.thickness) h = 1 / stretch.determinant();
  for (std::size_t i = 0; i < x.sheet.contact.size(); ++i) x.sheet.contact[i] = Contact::mold;
  lay_chart(x, radius, [&](const Vector2d& st) -> Vector2d { return stretch * st; });
  return x;
}
inline Sample flat(double side, int n, double radius = 1e9) {
  return stretched(side, n, Matrix2d::Identity(), radius);
}

// A dome of radius 60 mm on the platform. The part of the sheet within 70 mm of the top lies on it down to 80
// degrees from the pole, the rest runs out to the frame. Its chart keeps every meridian's length.
inline Sample dome(int n) {
  constexpr double radius = 60, reach = 70, steepest = 80 * M_PI / 180;
  Sample x = grid(300, n);
  const auto angle = [](double r) { return steepest * r / reach; };
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i) {
    const Vector2d st = x.sheet.rest[i];
    const double r = st.norm();
    const Vector2d along = r > 0 ? Vector2d(st / r) : Vector2d(1, 0);
    const double a = angle(std::min(r, reach));
    Vector3d p(radius * std::sin(a) * along.x(), radius * std::sin(a) * along.y(), radius * std::cos(a));
    if (r <= reach) {
      x.sheet.contact[i] = Contact::mold;
    } else {
      const double f = std::min(1.0, (r - reach) / 30), foot = p.z();
      const double out = radius * std::sin(a) + (r - radius * std::sin(a)) * f * f;
      p = {out * along.x(), out * along.y(), foot * (1 - f) * (1 - f)};
      if (x.sheet.contact[i] != Contact::clamp)
        x.sheet.contact[i] = f < 1 ? Contact::free : Contact::platform;
    }
    x.sheet.formed[i] = p;
  }
  for (std::size_t t = 0; t < x.sheet.triangles.size(); ++t) {
    const auto& c = x.sheet.triangles[t];
    const auto rest = [&](int k) {
      return x.sheet.rest[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])];
    };
    const auto formed = [&](int k) {
      return x.sheet.formed[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])];
    };
    const Vector2d p = rest(1) - rest(0), q = rest(2) - rest(0);
    const double before = std::abs(p.x() * q.y() - p.y() * q.x());
    x.sheet.element_thickness[t] = before / (formed(1) - formed(0)).cross(formed(2) - formed(0)).norm();
  }
  std::vector<double> sum(x.sheet.rest.size(), 0), count(x.sheet.rest.size(), 0);
  for (std::size_t t = 0; t < x.sheet.triangles.size(); ++t)
    for (const int v : x.sheet.triangles[t])
      sum[static_cast<std::size_t>(v)] += x.sheet.element_thickness[t],
          count[static_cast<std::size_t>(v)] += 1;
  for (std::size_t i = 0; i < sum.size(); ++i) x.sheet.thickness[i] = sum[i] / count[i];
  lay_chart(x, reach, [&](const Vector2d& st) -> Vector2d {
    return st.norm() > 0 ? Vector2d(radius * angle(st.norm()) * st / st.norm()) : Vector2d(0, 0);
  });

  // The mold: the same dome, 2 degrees a facet, down to the platform.
  x.mold.top = {0, 0, radius};
  constexpr int rings = 45, spokes = 90;
  auto& mesh = x.mold.mesh;
  mesh.vertices.push_back(x.mold.top);
  for (int j = 1; j <= rings; ++j)
    for (int i = 0; i < spokes; ++i) {
      const double a = M_PI / 2 * j / rings, b = 2 * M_PI * i / spokes;
      mesh.vertices.push_back(radius *
                              Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  const auto at = [&](int j, int i) { return 1 + (j - 1) * spokes + i % spokes; };
  for (int i = 0; i < spokes; ++i) mesh.triangles.push_back({0, at(1, i), at(1, i + 1)});
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < spokes; ++i) {
      mesh.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
    }
  return x;
}

}  // namespace vacuform::hand_made
