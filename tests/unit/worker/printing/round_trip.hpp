// Round trip over a head: a viewer of the formed print sees the drawing.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/ring_files.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/printing/print.hpp"
#include "worker/scan/mold.hpp"
#include "worker/surface/exact_geodesics.hpp"

namespace vacuform::round_trip {

using namespace drawing_files;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Head {
  Settings settings;
  FormedSheet sheet;
  InkedSurface surface;
  Flattening flattening;
};
inline Head formed_head(const drawing_files::Bytes& scan, std::optional<double> trim_mm) {
  Settings settings;
  settings.sheet.resolution_mm = 3;
  settings.scan.trim_mm = trim_mm;
  settings.print.marks = false;
  const auto mold = make_mold(scan, "head.stl", settings.scan, Context());
  if (!mold) throw std::runtime_error(mold.error().text());
  auto sheet =
      form(*mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context());
  if (!sheet) throw std::runtime_error(sheet.error().text());
  InkedSurface surface = inked_surface(*sheet, InkedFace::outer);
  auto flat = flatten(*sheet, surface, *mold, settings.flattening, Context());
  if (!flat) throw std::runtime_error(flat.error().text());
  return {settings, std::move(*sheet), std::move(surface), std::move(*flat)};
}

// A sample of the formed surface.
struct Sample {
  SheetPoint at;
  double mm2;
};
inline std::vector<Sample> samples_of(const Head& head, int t) {
  constexpr int cells = 8;  // along a triangle's side: samples 0.4 mm apart
  const Triangle& c = head.sheet.triangles[static_cast<std::size_t>(t)];
  const auto at = [&](std::size_t k) { return head.surface.inked()[static_cast<std::size_t>(c[k])]; };
  const double mm2 = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2 / (cells * cells);
  std::vector<Sample> out;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < 2 * (cells - i) - 1; ++j) {
      const double x = (i + (j % 2 == 0 ? 1.0 : 2.0) / 3) / cells,
                   y = (j / 2 + (j % 2 == 0 ? 1.0 : 2.0) / 3) / cells;
      out.push_back({{t, Vector3d(1 - x - y, x, y)}, mm2});
    }
  return out;
}

// Interpolates between the pixels: their edges are smooth.
inline double ink_at(const Decoded& image, const Vector2d& seen) {
  const double x = seen.x() * image.width - 0.5, y = (1 - seen.y()) * image.height - 0.5;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const auto row = [&](int k) { return (i + 1 - x) * image.at(i, k) + (x - i) * image.at(i + 1, k); };
  return 1 - ((j + 1 - y) * row(j) + (y - j) * row(j + 1)) / 255;
}

// Seven rings of 40 mm, 3 mm wide, at 300 dpi. The map of a ring on a dome keeps areas: a point of the formed surface
// has ink if the area nearer to the ring's centre, measured along the surface, is within the areas of the line's edges
// in the drawing. The print is looked up at the position of that point on the flat sheet.
inline void expect_round_rings(const drawing_files::Bytes& scan, std::optional<double> trim_mm) {
  const Head head = formed_head(scan, trim_mm);
  const ChartedSurface charted(head.surface, head.flattening);
  const drawing_files::Bytes bytes = ring_file("rings-7x40mm.svg");
  const auto pattern = Pattern::read(bytes, "rings", head.settings.pattern, head.settings.print.dpi);
  ASSERT_TRUE(pattern);
  std::vector<Warning> warnings;
  const auto drawing = read_drawing(*pattern, warnings);
  ASSERT_TRUE(drawing);
  const auto placement = place(charted, &*drawing, head.settings, Context());
  ASSERT_TRUE(placement);
  ASSERT_EQ(placement->elements.size(), 7u);
  const auto source = drawing_layer(*pattern, *drawing, *placement, head.settings, Context());
  ASSERT_TRUE(source);
  const auto print = make_print({.charted = charted,
                                 .placement = *placement,
                                 .settings = head.settings,
                                 .label = {},
                                 .layers = {{.name = "print", .source = *source}}},
                                Context());
  ASSERT_TRUE(print);
  const Decoded image = decode_png(print->main().files.png);

  constexpr double reach = 24;
  const auto& inked = head.surface.inked();
  std::vector<char> near(head.sheet.triangles.size() * 64, 0), wanted(near);
  for (const PlacedElement& element : placement->elements) {
    ASSERT_TRUE(element.on_head);
    SheetPoint centre{-1, Vector3d::Zero()};
    double least = HUGE_VAL;
    for (std::size_t t = 0; t < head.sheet.triangles.size(); ++t) {
      const Triangle& c = head.sheet.triangles[t];
      const auto at = [&](std::size_t k) { return inked[static_cast<std::size_t>(c[k])]; };
      const Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0)), p = element.centre;
      Vector3d w;
      for (std::size_t k = 0; k < 3; ++k)
        w[static_cast<Eigen::Index>(k)] =
            (at((k + 1) % 3) - p).cross(at((k + 2) % 3) - p).dot(normal) / normal.squaredNorm();
      const double off = std::abs((p - at(0)).dot(normal.normalized()));
      if (w.minCoeff() >= -1e-9 && off < least) least = off, centre = {static_cast<int>(t), w};
    }
    ASSERT_LT(least, 1e-6);
    Geodesics ways(head.surface.path_mesh());
    ways.begin_at(centre, reach);
    struct Reached {
      double mm, mm2;
      std::size_t sample;
    };
    std::vector<Reached> reached;
    for (std::size_t t = 0; t < head.sheet.triangles.size(); ++t) {
      if ((inked[static_cast<std::size_t>(head.sheet.triangles[t][0])] - element.centre).norm() > reach)
        continue;
      const auto samples = samples_of(head, static_cast<int>(t));
      for (std::size_t i = 0; i < samples.size(); ++i)
        if (const auto way = ways.to(samples[i].at))
          reached.push_back({way->length, samples[i].mm2, 64 * t + i});
    }
    std::sort(reached.begin(), reached.end(), [](const Reached& a, const Reached& b) { return a.mm < b.mm; });
    double within = 0;
    for (const Reached& r : reached) {
      within += r.mm2;
      near[r.sample] = 1;
      if (within > M_PI * 18.5 * 18.5 && within < M_PI * 21.5 * 21.5) wanted[r.sample] = 1;
    }
    EXPECT_GT(within, M_PI * 21.5 * 21.5);
  }

  double both = 0, either = 0;
  for (std::size_t t = 0; t < head.sheet.triangles.size(); ++t) {
    if (std::none_of(near.begin() + 64 * static_cast<std::ptrdiff_t>(t),
                     near.begin() + 64 * static_cast<std::ptrdiff_t>(t + 1), [](char c) { return c != 0; }))
      continue;
    const auto samples = samples_of(head, static_cast<int>(t));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!near[64 * t + i]) continue;
      const Vector2d seen =
          print->picture_uv(interpolate(head.sheet.triangles, samples[i].at, head.sheet.rest));
      const bool printed = ink_at(image, seen) > 0.5;
      both += wanted[64 * t + i] && printed ? samples[i].mm2 : 0;
      either += wanted[64 * t + i] || printed ? samples[i].mm2 : 0;
    }
  }
  EXPECT_GT(either, 2000);  // mm2
  testing::Test::RecordProperty("overlap", std::to_string(both / either));
  EXPECT_GE(both / either, 0.98);
}

}  // namespace vacuform::round_trip
