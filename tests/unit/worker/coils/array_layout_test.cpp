#include "worker/coils/array_layout.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/coils/coupled_neighbours.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;
using hand_made::Sample;

LayoutSettings wish(int count, double diameter_mm, ArrayRegion region = ArrayRegion::dome,
                    double overlap = 0) {
  LayoutSettings w;
  w.count = count;
  w.diameter_mm = diameter_mm;
  w.region = region;
  w.overlap = overlap;
  return w;
}

TEST(ArrayLayout, LaysSevenOnASphereAsAFlowerThatLandsInPlace) {
  const Sample x = hand_made::sphere(80, 260, 90, 110);
  const auto array = lay_out_array(hand_made::Charted(x), wish(7, 40), CoilSettings(), Context());
  ASSERT_TRUE(array) << array.error().text();
  EXPECT_EQ(array->pairs, 12);
  EXPECT_EQ(array->off_head, 0);
  ASSERT_TRUE(array->strongest_neighbours && array->strongest);
  EXPECT_LT(std::abs(array->strongest_neighbours->k), 0.01);
  // Loops of the rim with one between them couple twice as strongly as neighbours may.
  EXPECT_LT(array->strongest->k, -0.01);
  EXPECT_GT(array->strongest->k, -0.03);
  EXPECT_NEAR(array->spacing_mm, 30, 0.8);
  Settings settings;
  settings.coils.decouple = true;
  const hand_made::Charted charted(x);
  auto placed = place(charted, &array->drawing, settings, Context());
  ASSERT_TRUE(placed);
  ASSERT_TRUE(add_couplings(charted, array->drawing, settings, Context(), *placed));
  ASSERT_EQ(placed->elements.size(), 7u);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_LT((placed->elements[i].centre - array->centres[i]).norm(), 0.5);
}

TEST(ArrayLayout, FitsTheFrontHalfAndRefusesWhatHasNoRoom) {
  const Sample x = hand_made::sphere(80, 260, 90, 110);
  const auto array =
      lay_out_array(hand_made::Charted(x), wish(5, 0, ArrayRegion::front), CoilSettings(), Context());
  ASSERT_TRUE(array) << array.error().text();
  EXPECT_EQ(array->centres.size(), 5u);
  for (const Vector3d& c : array->centres) EXPECT_GT(c.y(), 0);
  EXPECT_GT(array->diameter_mm, 40);
  const auto refused = lay_out_array(hand_made::Charted(x), wish(64, 80), CoilSettings(), Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::unusable_surface);
  EXPECT_NE(refused.error().fix.find("of this diameter fit"), std::string::npos);
}

// All of one size, their centres as far apart as asked for; printed without decoupling they land there.
TEST(ArrayLayout, KeepsTheOverlapThatIsAskedFor) {
  const Sample x = hand_made::sphere(80, 260, 90, 110);
  const hand_made::Charted charted(x);
  for (const double overlap : {0.6, 1.1}) {
    const auto array =
        lay_out_array(charted, wish(7, 35, ArrayRegion::dome, overlap), CoilSettings(), Context());
    ASSERT_TRUE(array) << array.error().text();
    EXPECT_EQ(array->pairs, 12);
    EXPECT_NEAR(array->spacing_mm, overlap * 35, 0.3);
    // On this sphere six loops as far from the middle one as 38.5 mm are only 37.4 mm from each other.
    EXPECT_LT(array->spacing_rms_mm, 0.7);
    ASSERT_TRUE(array->strongest_neighbours);
    // Closer loops couple with the sense of their currents, loops beside each other against it.
    EXPECT_GT(overlap < 0.75 ? array->strongest_neighbours->k : -array->strongest_neighbours->k, 0.01);
    for (const Element& e : array->drawing.elements)
      EXPECT_NEAR((e.shapes[0].curves[0].points[0] - e.centre).norm(), 17.5, 1e-9);
    const auto placed = place(charted, &array->drawing, Settings(), Context());
    ASSERT_TRUE(placed);
    ASSERT_EQ(placed->elements.size(), 7u);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_LT((placed->elements[i].centre - array->centres[i]).norm(), 0.5);
  }
}

TEST(ArrayLayout, IsWrittenAsAGroupACoil) {
  Drawing drawing;
  drawing.size_mm = {50, 40};
  drawing.elements = {hand_made::ring("coil-1", {3, 4}, 10)};
  const std::string svg = svg_of_rings(drawing, "one coil");
  EXPECT_NE(svg.find("width=\"50.000mm\" height=\"40.000mm\" viewBox=\"-25.000 -20.000 50.000 40.000\""),
            std::string::npos);
  EXPECT_NE(svg.find("<g id=\"coil-1\"><circle cx=\"3.0000\" cy=\"-4.0000\" r=\"10.0000\" fill=\"none\" "
                     "stroke=\"#000\" stroke-width=\"3.000\"/></g>"),
            std::string::npos);
}

}  // namespace
}  // namespace vacuform
