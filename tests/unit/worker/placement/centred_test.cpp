// A drawing without an offset is centred on the middle of the mold's highest part: from the file to the formed sheet.
#include <gtest/gtest.h>

#include "tests/unit/fixtures/plateaus.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/placement/charted_surface.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {
namespace {

// The horizontal distance between the chart's origin on the formed sheet and the middle of the solid's top, mm.
double off_centre(const plateaus::Solid& solid, double grid_mm) {
  Settings s;
  s.sheet.resolution_mm = grid_mm;
  s.scan.up = UpAxis::plus_z;
  s.scan.units = Unit::mm;
  s.scan.trim_mm = 0;
  const auto mold = make_mold(stl_bytes(solid.mesh), "solid.stl", s.scan, Context());
  EXPECT_TRUE(mold) << solid.name << ": " << mold.error().text();
  if (!mold) return HUGE_VAL;
  const auto sheet = form(*mold, s.sheet, s.machine, s.forming, TemperatureField(140), Context());
  EXPECT_TRUE(sheet) << solid.name << ": " << sheet.error().text();
  if (!sheet) return HUGE_VAL;
  const InkedSurface surface = inked_surface(*sheet, InkedFace::outer);
  const auto flat = flatten(*sheet, surface, *mold, s.flattening, Context());
  EXPECT_TRUE(flat) << solid.name << ": " << flat.error().text();
  if (!flat) return HUGE_VAL;
  const auto origin = ChartedSurface(surface, *flat).at_chart({0, 0});
  EXPECT_EQ(origin.off_mm, 0) << solid.name;
  return (surface.place(origin.point) - mold->placing(solid.top)).head<2>().norm();
}

TEST(Centred, OnBlocksDiscsFrustaConesAndRoofsAtOddAngles) {
  const std::vector<std::pair<plateaus::Solid, double>> turned{
      {plateaus::block({80, 60, 30}, false), 5},
      {plateaus::block({80, 60, 30}, false), 30},
      {plateaus::block({80, 60, 30}, true), 45},
      {plateaus::prism(3, 40, 25, false), 20},
      {plateaus::prism(7, 40, 25, true), 85},
      {plateaus::prism(12, 45, 20, false), 10},
      {plateaus::prism(200, 45, 20, false), 55},
      {plateaus::frustum(39, 50, 25, 30, {7, -4}, false), 35},
      {plateaus::frustum(40, 50, 25, 30, {7, -4}, true), 70},
      {plateaus::cone(100, 45, 30, {6, 3}), 40},
      {plateaus::roof(70, 90, 25, -20, 35), 15}};
  for (const auto& [solid, yaw] : turned) {
    const plateaus::Solid at = plateaus::turned(solid, yaw);
    EXPECT_LT(off_centre(at, 3), 0.01) << at.name;
  }
  EXPECT_LT(off_centre(plateaus::turned(plateaus::block({80, 60, 30}, false), 17), 1.5), 0.01);
}

}  // namespace
}  // namespace vacuform
