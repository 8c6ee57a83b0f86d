// Errors of the colours that are known: a flat scan under a sheet that is stretched evenly, so that every millimetre of
// the print comes to lie on a known length of the part.
#include "worker/inspection/colour_errors.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "tests/unit/fixtures/coloured_scans.hpp"
#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/colour/colour_difference.hpp"
#include "worker/png/png_writer.hpp"
#include "worker/printing/colour_raster.hpp"

namespace vacuform {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double sheet_mm = 80, scan_mm = 200, dot_mm = 0.1;

// A level square around the origin at this height, painted from its left back corner.
shapes::FileBytes square(double height_mm, const coloured::Paint& paint) {
  coloured::Model model;
  for (const Vector2d& uv :
       {Vector2d(0, 0), Vector2d(0, 1), Vector2d(1, 1), Vector2d(0, 0), Vector2d(1, 1), Vector2d(1, 0)}) {
    model.uv.push_back(uv);
    model.places.emplace_back(scan_mm * (uv.x() - 0.5), scan_mm * (0.5 - uv.y()), height_mm);
  }
  return coloured::glb(model, coloured::png(2000, 2000, paint));
}

coloured::Paint even(const Vector3f& linear) {
  return [=](double, double) { return linear; };
}
const Vector3f orange(0.6F, 0.25F, 0.05F);

// Red changes along x, blue across, so that no shift of the print goes unseen.
Vector3f rainbow(double u, double v) {
  return {static_cast<float>(0.5 + 0.4 * std::sin(300 * u)), 0.3F,
          static_cast<float>(0.5 + 0.4 * std::sin(300 * v))};
}

struct Case {
  Matrix2d stretch = Matrix2d::Identity();
  double below_mm = 0;  // how far the scan lies below the sheet
  coloured::Paint paint = even(orange);
  int columns_off = 0;  // how far the pixels of the print are moved to the right
  bool written_mirrored = false, said_mirrored = false;
  Vector3f (*printed_as)(const Vector3f&) = nullptr;  // changes the colours of the print; linear light
  std::optional<double> ink_for_ratio = {};           // the area ratio that the print states it compensates
};

Print print_with(PrintedColours colours, InkedFace face, std::vector<std::uint8_t> png,
                 const PrintGrid& grid) {
  Print print;
  print.grid = grid;
  print.layers.push_back({.name = "print", .face = face, .source = colour_layer(std::move(colours))});
  print.layers.back().files.png = std::move(png);
  return print;
}

ColourErrors errors_of(const Case& c) {
  const hand_made::Sample sample = hand_made::stretched(sheet_mm, 40, c.stretch);
  const auto scan = read_coloured_scan(square(-c.below_mm, c.paint), "scan.glb", Context());
  EXPECT_TRUE(scan) << scan.error().text();
  const SheetColours colours(ColouredSurface(*scan, {}), sample.sheet, colour_reach(0, 3));
  constexpr int side = static_cast<int>(sheet_mm / dot_mm);
  const PrintGrid grid{side, side, dot_mm};
  const ColourRaster raster(colours, grid);
  PngWriter writer(side, side, 3);
  for (int y = 0; y < side; y += raster.band_rows()) {
    const int bottom = std::min(y + raster.band_rows(), side);
    const auto rows = raster.rows(y, bottom);
    for (int j = 0; j < bottom - y; ++j) {
      std::vector<std::uint8_t> line(3 * static_cast<std::size_t>(side), 255);
      for (int x = 0; x < side; ++x) {
        const int from = x - c.columns_off;
        if (from < 0 || from >= side) continue;
        const std::uint8_t* p = &rows[4 * static_cast<std::size_t>(j * side + from)];
        if (p[3] == 0) continue;
        Vector3f linear;
        for (int k = 0; k < 3; ++k) linear[k] = linear_from_srgb(static_cast<float>(p[k]) / 255);
        if (c.printed_as) linear = c.printed_as(linear);
        const int to = c.written_mirrored ? side - 1 - x : x;
        for (int k = 0; k < 3; ++k)
          line[static_cast<std::size_t>(3 * to + k)] = static_cast<std::uint8_t>(std::lround(
              255 - p[3] / 255.0 * (255 - 255 * static_cast<double>(srgb_from_linear(linear[k])))));
      }
      writer.row(line.data());
    }
  }
  PrintedColours printed{colours};
  if (c.ink_for_ratio)
    printed.ink = ColourInk{InkCurve(), std::vector<double>(sample.sheet.rest.size(), *c.ink_for_ratio)};
  const InkedFace face = c.said_mirrored ? InkedFace::inner : InkedFace::outer;
  const Print print = print_with(std::move(printed), face, writer.finish(), grid);
  auto errors = colour_errors(print, 2, Context());
  EXPECT_TRUE(errors);
  return *errors;
}

// Each place lies a quarter of a pixel off the centre of its pixel, both ways.
const double off_centre_mm = dot_mm * std::sqrt(2.0) / 4;

TEST(ColourErrors, AreAtMostAPixelInRegister) {
  const ColourErrors errors = errors_of({.paint = rainbow});
  for (const auto* figures : {&errors.whole, &errors.touching})
    for (const PlacedStatistics* error : {&figures->position, &figures->along}) {
      EXPECT_NEAR(error->values.mean, off_centre_mm, 1e-4);
      EXPECT_NEAR(error->values.max, off_centre_mm, 1e-4);
    }
  EXPECT_LT(errors.touching.colour.values.mean, 1);
}

TEST(ColourErrors, ContainTheGapBetweenSheetAndScan) {
  const ColourErrors errors = errors_of({.below_mm = 0.4});
  EXPECT_NEAR(errors.touching.position.values.mean, std::hypot(0.4, off_centre_mm), 1e-4);
  EXPECT_NEAR(errors.touching.along.values.mean, off_centre_mm, 1e-4);
  const ColourErrors bridged = errors_of({.below_mm = 1.5});
  EXPECT_NEAR(bridged.whole.position.values.mean, std::hypot(1.5, off_centre_mm), 1e-4);
  EXPECT_EQ(bridged.touching.position.values.max, 0);  // nothing touches
  EXPECT_GT(bridged.whole.colour.values.mean, 5);      // the colours are faded to two thirds
}

// One millimetre of the print is two of the part along s, and one and a quarter along t.
TEST(ColourErrors, OfAShiftedPrintAreTheShiftAsTheSheetStretchesIt) {
  Matrix2d stretch;
  stretch << 2, 0, 0, 1.25;
  const ColourErrors errors = errors_of({.stretch = stretch, .paint = rainbow});
  ASSERT_EQ(errors.off_register.size(), 2U);
  EXPECT_EQ(errors.off_register[0].shift_mm, 0.5);
  EXPECT_EQ(errors.off_register[1].shift_mm, 1);
  double less = errors.touching.colour.values.mean;
  for (const auto& off : errors.off_register) {
    // At the border of the sheet one of the four shifts leaves it.
    EXPECT_NEAR(off.touching.along.values.mean, off.shift_mm * (2 + 1.25) / 2, 0.02);
    EXPECT_NEAR(off.touching.along.values.max, 2 * off.shift_mm, 2 * off_centre_mm);
    EXPECT_NEAR(off.touching.position.values.p95, 2 * off.shift_mm, 2 * off_centre_mm);
    EXPECT_GT(off.touching.colour.values.mean, less + 1);
    less = off.touching.colour.values.mean;
  }
}

TEST(ColourErrors, OfAnEvenChangeOfColourAreItsDifference) {
  const ColourErrors errors =
      errors_of({.printed_as = [](const Vector3f&) { return Vector3f(0.5F, 0.3F, 0.1F); }});
  const double expected = ciede2000(lab_of(orange), lab_of({0.5F, 0.3F, 0.1F}));
  EXPECT_GT(expected, 5);
  for (const double value :
       {errors.whole.colour.values.mean, errors.whole.colour.values.max, errors.touching.colour.values.p95})
    EXPECT_NEAR(value, expected, 0.3);  // both are rounded to eight bits
  EXPECT_NEAR(errors.touching.along.values.mean, off_centre_mm, 1e-4);
  EXPECT_LT(errors_of({}).whole.colour.values.max, 0.01);
}

// A print with twice the ink shows the colour of the scan once its area has doubled.
TEST(ColourErrors, CompareWhatTheStretchedSheetShowsOfCompensatedInk) {
  const Vector3f pale(0.6F, 0.8F, 0.9F), twice = Vector3f::Ones() - 2 * (Vector3f::Ones() - pale);
  const Case c{.paint = even(pale), .printed_as = [](const Vector3f& linear) -> Vector3f {
                 return Vector3f::Ones() - 2 * (Vector3f::Ones() - linear);
               }};
  Case compensated = c;
  compensated.ink_for_ratio = 2;
  EXPECT_LT(errors_of(compensated).touching.colour.values.max, 0.5);
  EXPECT_NEAR(errors_of(c).touching.colour.values.mean, ciede2000(lab_of(twice), lab_of(pale)), 0.3);
}

// What is measured is the file: pixels that are moved in it, or mirrored without being said to be, look different.
TEST(ColourErrors, SeeAPrintThatIsMovedOrMirrored) {
  const auto mean = [](const Case& c) { return errors_of(c).touching.colour.values.mean; };
  const double in_place = mean({.paint = rainbow});
  EXPECT_GT(mean({.paint = rainbow, .columns_off = 3}), 3 * in_place);
  EXPECT_GT(mean({.paint = rainbow, .written_mirrored = true}), 10 * in_place);
  EXPECT_NEAR(mean({.paint = rainbow, .written_mirrored = true, .said_mirrored = true}), in_place, 1e-9);
}

TEST(ColourErrors, FindWhereAShiftIsSeenMost) {
  // Black left of x = 7 mm, white right of it.
  const ColourErrors errors = errors_of({.paint = [](double u, double) {
    return Vector3f::Constant(scan_mm * (u - 0.5) < 7 ? 0.F : 1.F).eval();
  }});
  EXPECT_NEAR(errors.most_changed.place.x(), 7, 2.1);
  EXPECT_NEAR(std::abs(errors.most_changed.towards.x()), 1, 1e-12);
  EXPECT_NEAR(errors.most_changed.outward.z(), 1, 1e-9);
}

TEST(ColourErrors, HaveAValueAtEveryColouredVertexAndNoOther) {
  const hand_made::Sample sample = hand_made::dome(100);
  const auto scan = read_coloured_scan(
      coloured::glb(coloured::sphere(60, 160), coloured::png(8, 8, even(orange))), "scan.glb", Context());
  ASSERT_TRUE(scan);
  const SheetColours colours(ColouredSurface(*scan, {}), sample.sheet, colour_reach(0, 3));
  constexpr int side = 1500;
  PngWriter writer(side, side, 3);
  const std::vector<std::uint8_t> white(4500, 255);
  for (int y = 0; y < side; ++y) writer.row(white.data());
  const Print print = print_with({colours}, InkedFace::outer, writer.finish(), {side, side, 0.2});
  const auto errors = colour_errors(print, 3, Context());
  ASSERT_TRUE(errors);
  const double of_white = ciede2000(lab_of(orange), lab_of(Vector3f::Ones()));
  int on_dome = 0;
  for (std::size_t v = 0; v < sample.sheet.rest.size(); ++v) {
    const double position = errors->position_of_vertices[v], colour = errors->colour_of_vertices[v];
    if (sample.sheet.rest[v].norm() < 66) {
      ASSERT_GE(position, 0) << v;
      ASSERT_LT(position, 0.4) << v;
      ASSERT_NEAR(colour, of_white, 0.3) << v;
      ++on_dome;
    } else if (sample.sheet.rest[v].norm() > 110) {
      ASSERT_TRUE(std::isnan(position) && std::isnan(colour)) << v;
    }
  }
  EXPECT_GT(on_dome, 1000);
}

TEST(ColourErrors, AreTheSameWithOneThread) {
  const Case c{.below_mm = 0.1, .paint = rainbow};
  const ColourErrors many = errors_of(c);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ColourErrors alone = errors_of(c);
  EXPECT_EQ(many.position_of_vertices, alone.position_of_vertices);
  EXPECT_EQ(many.colour_of_vertices, alone.colour_of_vertices);
  EXPECT_EQ(many.off_register[1].touching.colour.values.mean,
            alone.off_register[1].touching.colour.values.mean);
  EXPECT_EQ(many.whole.colour.place, alone.whole.colour.place);
}

}  // namespace
}  // namespace vacuform
