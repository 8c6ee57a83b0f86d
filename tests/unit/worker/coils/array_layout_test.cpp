#include "worker/coils/array_layout.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/coils/coupled_neighbours.hpp"

namespace vacuform::array_layout_test {
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
  // Printed, with decoupling or without, the loops lie there.
  const hand_made::Charted charted(x);
  for (const bool decouple : {false, true}) {
    Settings settings;
    settings.coils.decouple = decouple;
    auto placed = place(charted, &array->drawing, settings, Context());
    ASSERT_TRUE(placed);
    ASSERT_TRUE(add_couplings(charted, array->drawing, settings, Context(), *placed));
    ASSERT_EQ(placed->elements.size(), 7u);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_LT((placed->elements[i].centre - array->centres[i]).norm(), decouple ? 0.5 : 0.02);
    if (decouple) continue;
    double strongest = 0;
    for (const PlacedPair& pair : placed->pairs)
      if (std::abs(*pair.k) > std::abs(strongest)) strongest = *pair.k;
    EXPECT_NEAR(strongest, array->strongest_neighbours->k, 0.0005);
  }
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
      EXPECT_LT((placed->elements[i].centre - array->centres[i]).norm(), 0.02);
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
  drawing.elements[0].place = CoilPlace{{1, -2, 80.5}, {0, 1, 0}, {3, 4}};
  EXPECT_NE(svg_of_rings(drawing, "one coil")
                .find("<g id=\"coil-1\" data-place=\"1.0000 -2.0000 80.5000 0.000000 1.000000 0.000000 "
                      "3.0000 4.0000\">"),
            std::string::npos);
}

// What a person does with it in a drawing program.
class EditedLayout : public testing::Test {
 protected:
  void SetUp() override {
    auto made = lay_out_array(charted_, wish(9, 32), CoilSettings(), Context());
    ASSERT_TRUE(made) << made.error().text();
    array_ = *std::move(made);
    svg_ = svg_of_rings(array_.drawing, "nine coils");
  }

  Placement printed(const std::string& svg, const ChartedSurface& on, const Settings& settings = {}) const {
    std::vector<Warning> warnings;
    const auto drawing = read_drawing(svg, array_.drawing.size_mm, warnings);
    EXPECT_TRUE(drawing && warnings.empty());
    auto placement = place(on, &*drawing, settings, Context());
    EXPECT_TRUE(placement);
    return *std::move(placement);
  }
  std::string with(const std::string& from, const std::string& to) const {
    std::string out = svg_;
    const auto at = out.find(from);
    EXPECT_NE(at, out.npos);
    return out.replace(at, from.size(), to);
  }
  static std::vector<std::string> codes(const Placement& placement) {
    std::vector<std::string> out;
    for (const Warning& w : placement.warnings) out.push_back(w.code);
    return out;
  }

  Sample x_ = hand_made::sphere(80, 260, 90, 110);
  hand_made::Charted charted_{x_};
  Array array_;
  std::string svg_;
};

TEST_F(EditedLayout, KeepsItsPlacesWhenTheDrawingIsMovedOnThePage) {
  std::string moved = with("</title>", "</title><g transform=\"translate(7 -3)\">");
  moved.insert(moved.rfind("</svg>"), "</g>");
  const Placement p = printed(moved, charted_);
  ASSERT_EQ(p.elements.size(), 9u);
  EXPECT_TRUE(codes(p).empty());
  for (std::size_t i = 0; i < 9; ++i) EXPECT_LT((p.elements[i].centre - array_.centres[i]).norm(), 0.02) << i;
}

TEST_F(EditedLayout, MovesALoopByAsMuchAsItIsMovedInTheDrawing) {
  const Placement p =
      printed(with("<g id=\"coil-5\"", "<g id=\"coil-5\" transform=\"translate(4 -3)\""), charted_);
  ASSERT_EQ(p.elements.size(), 9u);
  EXPECT_TRUE(codes(p).empty());
  for (std::size_t i = 0; i < 9; ++i)
    EXPECT_NEAR((p.elements[i].centre - array_.centres[i]).norm(), i == 4 ? 5 : 0, 0.03) << i;
}

TEST_F(EditedLayout, PlacesALoopThatWasAddedByItsNeighbours) {
  const std::string added =
      with("</svg>", "<circle cx=\"70\" cy=\"2\" r=\"9\" fill=\"none\" stroke=\"#000\"/></svg>");
  const Placement p = printed(added, charted_);
  ASSERT_EQ(p.elements.size(), 10u);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_LT((p.elements[i].centre - array_.centres[i]).norm(), 0.02) << i;
  for (const PlacedPair& pair : p.pairs)
    EXPECT_LT(std::abs(pair.mm - pair.drawn_mm), pair.b == 9 ? 6 : 100) << pair.a;
}

TEST_F(EditedLayout, SaysThatItWasMadeForAnotherHead) {
  const Sample other = hand_made::sphere(83, 260, 90, 110);
  const hand_made::Charted on(other);
  const Placement p = printed(svg_, on);
  EXPECT_EQ(codes(p), std::vector<std::string>{"places-unused"});
  EXPECT_NE(p.warnings[0].text.find("laid out for another head"), std::string::npos);
  Settings settings;
  settings.pattern.rotate_deg = 10;
  EXPECT_EQ(codes(printed(svg_, charted_, settings)), std::vector<std::string>{"places-unused"});
}

}  // namespace
}  // namespace vacuform::array_layout_test
