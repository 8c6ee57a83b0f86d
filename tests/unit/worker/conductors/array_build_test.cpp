#include "worker/conductors/array_build.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/conductors/interrupted.hpp"
#include "worker/pattern/pieces.hpp"

namespace vacuform {
namespace {

using namespace hand_made;

// Seven rings on a sphere of 90 mm; the other face is .8 mm below.
struct Rings {
  Sample sheet = sphere(90, 440, 140);
  Sample below = sphere(89.2, 440, 140);
  Charted surface{sheet}, reverse{below.sheet, below.flattening};
  Drawing drawing = seven_rings(30, 1.516 * 30);
  Settings settings;
  std::optional<BodyBelow> body = BodyBelow{{{0, 0, 0}, 88, 0}, 2};

  Rings() {
    // The same points of the sheet on both faces.
    for (std::size_t i = 0; i < sheet.sheet.formed.size(); ++i)
      below.sheet.formed[i] = sheet.sheet.formed[i] * 89.2 / 90;
  }
  ArrayBuild build() {
    const Charted other(below.sheet, below.flattening);
    const auto placement = place(surface, &drawing, settings, Context());
    return *build_array(drawing, *placement, {surface, other}, body, settings, Context());
  }
};

const BuiltLayer* layer(const ArrayBuild& build, PrintStep step, int face) {
  for (const BuiltLayer& each : build.layers)
    if (each.step == step && each.face == face) return &each;
  return nullptr;
}

double ink(const Element& element) {
  double out = 0;
  for (const Shape& shape : element.shapes) out += ink_mm2(shape);
  return out;
}

TEST(ArrayBuild, OfOneLayerIsTheDrawing) {
  Rings rings;
  const ArrayBuild build = rings.build();
  ASSERT_EQ(build.layers.size(), 1u);
  EXPECT_TRUE(build.bridges.empty() && build.gaps.empty() && build.warnings.empty());
  for (std::size_t e = 0; e < 7; ++e)
    EXPECT_NEAR(ink(build.layers[0].drawing.elements[e]), ink(rings.drawing.elements[e]), 1e-9);
}

TEST(ArrayBuild, WithBridgesInterruptsOneOfTwoLoops) {
  Rings rings;
  rings.settings.coils.build = CoilBuild::bridges;
  const ArrayBuild build = rings.build();
  EXPECT_TRUE(build.warnings.empty()) << build.warnings.front().text;
  ASSERT_EQ(build.layers.size(), 3u);
  ASSERT_EQ(build.bridges.size(), 24u);
  EXPECT_FALSE(build.reverse);
  const BuiltLayer *conductor = layer(build, PrintStep::conductor, 0),
                   *bridges = layer(build, PrintStep::bridges, 0),
                   *dielectric = layer(build, PrintStep::dielectric, 0);
  ASSERT_TRUE(conductor && bridges && dielectric);
  for (std::size_t e = 0; e < 7; ++e) {
    double cut = 0, above = 0, patches = 0;
    for (const Bridge& b : build.bridges) {
      if (b.over() == static_cast<int>(e)) cut += 2 * b.cut * 3, above += 2 * b.reach * 3;
      if (b.under() == static_cast<int>(e)) patches += 2 * b.patch * 4;
    }
    EXPECT_NEAR(ink(conductor->drawing.elements[e]), ink(rings.drawing.elements[e]) - cut, 0.5) << e;
    EXPECT_NEAR(ink(bridges->drawing.elements[e]), above, 0.5);
    EXPECT_NEAR(ink(dielectric->drawing.elements[e]), patches, 0.5);
  }
}

TEST(ArrayBuild, OnTwoFacesNeedsFewerBridges) {
  Rings rings;
  rings.settings.coils.build = CoilBuild::two_faces;
  const ArrayBuild build = rings.build();
  EXPECT_EQ(build.bridges.size(), 6u);
  ASSERT_TRUE(build.reverse);
  for (std::size_t i = 0; i < build.reverse->elements.size(); ++i) {
    EXPECT_NEAR(build.reverse->elements[i].centre.norm(), 89.2, 0.05);
    EXPECT_LT((build.reverse->elements[i].centre_rest -
               place(rings.surface, &rings.drawing, rings.settings, Context())->elements[i].centre_rest)
                  .norm(),
              1e-6);
  }
  const BuiltLayer *outer = layer(build, PrintStep::conductor, 0),
                   *inner = layer(build, PrintStep::conductor, 1);
  ASSERT_TRUE(outer && inner);
  for (std::size_t e = 0; e < 7; ++e)
    EXPECT_NE(outer->drawing.elements[e].shapes.empty(), inner->drawing.elements[e].shapes.empty());
}

TEST(ArrayBuild, LeavesGapsWithPads) {
  Rings rings;
  rings.settings.coils.build = CoilBuild::bridges;
  rings.settings.coils.gaps = 4;
  const ArrayBuild build = rings.build();
  ASSERT_EQ(build.gaps.size(), 28u);
  int ports = 0;
  for (const LoopGap& gap : build.gaps) {
    ports += gap.port;
    EXPECT_NEAR(gap.along.length(), 0.9, 1e-9);
    EXPECT_NEAR(gap.place.norm(), 90, 0.05);
    const LoopPath path(*rings.drawing.elements[static_cast<std::size_t>(gap.coil)].loop);
    for (const Shape& shape :
         layer(build, PrintStep::conductor, 0)->drawing.elements[static_cast<std::size_t>(gap.coil)].shapes)
      EXPECT_LT(square_mm(intersection(stroke_area(shape.curves, *shape.stroke, 0.01),
                                       band(path, {{gap.along.from + 0.02, gap.along.to - 0.02}}))),
                0.01);
    for (const Bridge& b : build.bridges) {
      const bool over = b.over() == gap.coil;
      if (!over && b.under() != gap.coil) continue;
      EXPECT_GT(apart_on_loop(over ? b.along_over() : b.along_under(), gap.along.middle(), path.length()),
                (over ? b.reach : b.patch) + 0.9 / 2 + 1);
    }
  }
  EXPECT_EQ(ports, 7);
}

}  // namespace
}  // namespace vacuform
