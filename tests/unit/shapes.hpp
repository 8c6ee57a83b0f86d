// Molds of known shape, for tests.
#pragma once

#include <cmath>
#include <numbers>

#include "worker/scan/mold.hpp"

namespace vacuform {

// A half sphere of radius R on the platform, open below (a soup is enough for contact).
inline Mold hemisphere(double R, int rings = 90, int sectors = 180) {
  Mold mold;
  auto& m = mold.mesh;
  m.vertices.push_back({0, 0, R});
  for (int i = 1; i <= rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double polar = std::numbers::pi / 2 * i / rings, around = 2 * std::numbers::pi * j / sectors;
      m.vertices.push_back({R * std::sin(polar) * std::cos(around), R * std::sin(polar) * std::sin(around),
                            R * std::cos(polar)});
    }
  const auto at = [&](int i, int j) { return i == 0 ? 0 : 1 + (i - 1) * sectors + j % sectors; };
  for (int j = 0; j < sectors; ++j) {
    m.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i < rings; ++i) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  mold.top = {0, 0, R};
  return mold;
}

// The mold with a smooth dent of `depth` mm: `reach` radians across from its middle, which lies at (polar, around).
inline Mold dented(Mold mold, double polar, double around, double reach, double depth) {
  const Eigen::Vector3d middle(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                               std::cos(polar));
  for (auto& p : mold.mesh.vertices) {
    const double x = std::acos(std::min(1.0, p.normalized().dot(middle))) / reach;
    if (x < 1) p -= depth * (1 - x * x) * (1 - x * x) * p.normalized();
  }
  return mold;
}

}  // namespace vacuform
