// The ink for the colours of a sphere on a dome of radius 60 mm, whose area ratio is known at every place.
#include <gtest/gtest.h>

#include "tests/unit/fixtures/coloured_scans.hpp"
#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/colour_raster.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double radius_mm = 60, turn_per_mm = 80 * std::numbers::pi / 180 / 70;  // of hand_made::dome()
double area_ratio_at(double r) { return radius_mm * radius_mm * std::sin(turn_per_mm * r) * turn_per_mm / r; }

const FormedSheet& dome_of_ink() {
  static const FormedSheet sheet = hand_made::dome(150).sheet;
  return sheet;
}

SheetColours sphere_of(const Vector3f& linear) {
  const auto image = coloured::png(2, 2, [&](double, double) { return linear; });
  const auto surface =
      read_coloured_scan(coloured::glb(coloured::sphere(radius_mm, 240), image), "a.glb", Context());
  EXPECT_TRUE(surface) << surface.error().text();
  return SheetColours(ColouredSurface(*surface, {}), dome_of_ink(), colour_reach(0, 0));
}

constexpr int pixels = 600;
constexpr double pixel_size = 0.5;

std::vector<std::uint8_t> drawn(const SheetColours& colours, const ColourInk& ink, InkState shows) {
  const ColourRaster raster(colours, {pixels, pixels, pixel_size}, {&ink, shows});
  std::vector<std::uint8_t> rgba;
  for (int top = 0; top < pixels; top += raster.band_rows()) {
    const auto rows = raster.rows(top, std::min(top + raster.band_rows(), pixels));
    rgba.insert(rgba.end(), rows.begin(), rows.end());
  }
  return rgba;
}

// The largest difference from what is expected at a distance from the centre, up to 65 mm.
template <class Expected>
double largest_error(const std::vector<std::uint8_t>& rgba, Expected&& expected) {
  double most = 0;
  for (int y = 0; y < pixels; y += 3)
    for (int x = 0; x < pixels; x += 3) {
      const double r = pixel_size * std::hypot(x + 0.5 - pixels / 2.0, y + 0.5 - pixels / 2.0);
      if (r < 3 || r > 65) continue;
      const std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(y) * pixels + static_cast<std::size_t>(x))];
      const Vector3f wanted = expected(r);
      for (int c = 0; c < 3; ++c)
        most = std::max(most, std::abs(static_cast<double>(linear_from_srgb(static_cast<float>(p[c]) / 255)) -
                                       static_cast<double>(wanted[c])));
    }
  return most;
}

TEST(ColourInk, ALinearCurvePrintsTheCoverageTimesTheAreaRatio) {
  const Vector3f colour(0.8f, 0.6f, 0.4f);
  const SheetColours colours = sphere_of(colour);
  const ColourInk ink = colour_ink(hand_made::inked(dome_of_ink()), {});
  const auto print = drawn(colours, ink, InkState::printed);
  EXPECT_LT(largest_error(print,
                          [&](double r) -> Vector3f {
                            return Vector3f::Ones() -
                                   static_cast<float>(area_ratio_at(r)) * (Vector3f::Ones() - colour);
                          }),
            0.02);
  EXPECT_LT(largest_error(drawn(colours, ink, InkState::stretched), [&](double) { return colour; }), 0.005);
}

const InkCurveRows curved{{0, 0, 0, 0}, {0.2, 0.35, 0.3, 0.25}, {0.5, 0.75, 0.7, 0.6}, {1, 1.2, 1.1, 0.95}};

TEST(ColourInk, WhatTheCurvesPrinterLaysShowsTheColourOnTheFormedSheet) {
  const Vector3f colour(0.7f, 0.45f, 0.6f);
  const SheetColours colours = sphere_of(colour);
  const ColourInk ink = colour_ink(hand_made::inked(dome_of_ink()), curved);
  const auto print = drawn(colours, ink, InkState::printed);
  // The printer of the curve, by hand.
  const auto lays = [](int channel, double printed) {
    std::size_t i = 1;
    while (i + 1 < curved.size() && printed > curved[i][0]) ++i;
    const auto& a = curved[i - 1];
    const auto& b = curved[i];
    const auto k = static_cast<std::size_t>(channel) + 1;
    return a[k] + (b[k] - a[k]) * (printed - a[0]) / (b[0] - a[0]);
  };
  double most = 0;
  for (const int x : {310, 330, 360, 400, 420}) {
    const std::uint8_t* p =
        &print[4 * (static_cast<std::size_t>(pixels / 2) * pixels + static_cast<std::size_t>(x))];
    const double ratio = area_ratio_at(pixel_size * std::hypot(x + 0.5 - pixels / 2.0, 0.5));
    for (int c = 0; c < 3; ++c) {
      const double printed = 1 - static_cast<double>(linear_from_srgb(static_cast<float>(p[c]) / 255));
      most = std::max(most, std::abs(1 - lays(c, printed) / ratio - static_cast<double>(colour[c])));
    }
  }
  EXPECT_LT(most, 0.02);
}

TEST(ColourInk, ReportsWhereFullInkIsTooLittle) {
  const ColourInk ink = colour_ink(hand_made::inked(dome_of_ink()), {});
  const InkShortage found =
      ink_shortage(sphere_of({0.9f, 0.9f, 0.25f}), hand_made::inked(dome_of_ink()), ink);
  // Yellow of 75 % lacks more than 1 % where the ratio is above 1 / 0.74: up to a distance from the top.
  double r = 1;
  while (area_ratio_at(r) > 1 / 0.74) r += 0.01;
  const double area = 2 * std::numbers::pi * radius_mm * radius_mm * (1 - std::cos(turn_per_mm * r));
  EXPECT_NEAR(found.short_mm2, area, 0.03 * area);
  EXPECT_STREQ(ink_names[found.ink], "yellow");
  EXPECT_NEAR(found.lack, 0.75 - 1 / area_ratio_at(0.01), 0.003);
  EXPECT_LT(found.place.head<2>().norm(), 10);
  EXPECT_NEAR(found.place.norm(), radius_mm, 0.2);
  const auto warning = warning_of(found);
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->code, "ink-not-enough");
  EXPECT_NEAR(warning->figure->value, 100 * found.short_mm2 / found.coloured_mm2, 1e-9);
  EXPECT_NE(warning->text.find("5 % coverage of yellow"), std::string::npos) << warning->text;
}

TEST(ColourInk, SaysNothingWhereThereIsEnough) {
  const ColourInk linear = colour_ink(hand_made::inked(dome_of_ink()), {}),
                  strong = colour_ink(hand_made::inked(dome_of_ink()), {{0, 0, 0, 0}, {1, 1.5, 1.5, 1.5}});
  const InkShortage pale =
      ink_shortage(sphere_of({0.9f, 0.9f, 0.35f}), hand_made::inked(dome_of_ink()), linear);
  EXPECT_EQ(pale.short_mm2, 0);
  EXPECT_FALSE(warning_of(pale));
  const SheetColours dark = sphere_of({0, 0, 0});
  EXPECT_EQ(ink_shortage(dark, hand_made::inked(dome_of_ink()), strong).short_mm2, 0);
  const InkShortage all = ink_shortage(dark, hand_made::inked(dome_of_ink()), linear);
  EXPECT_GT(all.share(), 0.8);
}

TEST(InkCurve, InvertsWhatItGives) {
  const InkCurve curve(curved);
  for (std::size_t ink = 0; ink < 3; ++ink) {
    EXPECT_EQ(curve.most(ink), static_cast<float>(curved.back()[ink + 1]));
    for (const float c : {0.0f, 0.1f, 0.2f, 0.4f, 0.77f, 1.0f})
      EXPECT_NEAR(curve.printed(ink, curve.ink(ink, c)), c, 1e-6);
    EXPECT_EQ(curve.printed(ink, 3), 1);
  }
  EXPECT_NEAR(curve.ink(0, 0.35f), 0.55, 1e-6);
}

TEST(InkCurve, TakesTheLeastCoverageWhereTheInkNoLongerGrows) {
  const InkCurve curve({{0, 0, 0, 0}, {0.6, 0.8, 0.8, 0.8}, {1, 0.8, 0.9, 1}});
  EXPECT_NEAR(curve.printed(0, 0.8f), 0.6, 1e-6);
  EXPECT_NEAR(curve.printed(1, 0.85f), 0.8, 1e-6);
}

}  // namespace
}  // namespace vacuform
