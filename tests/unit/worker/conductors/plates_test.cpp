#include "worker/conductors/plates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/conductors/array_build.hpp"
#include "worker/electrical/sheet_dielectric.hpp"
#include "worker/pattern/pieces.hpp"

namespace vacuform {
namespace {

using namespace hand_made;

// Microstrip of 50 ohm (Hammerstad and Jensen, 1980, by their closed forms): width over thickness 1.8616 and permittivity 4.5
// have an effective one of 3.39, and C = sqrt(effective) / (c Z).
TEST(SheetDielectric, OfAPlateWithItsEdges) {
  EXPECT_NEAR(plate_pf_per_mm(8, 0.5, 3), 8.8541878e-3 * 48, 1e-9);
  EXPECT_NEAR(plate_pf_per_mm_with_edges(1.8616, 1, 4.5), std::sqrt(3.39) / 299.792458 / 50 * 1e3, 0.002);
  // Wide plates are hardly more than what is between them, narrow ones join without a step.
  EXPECT_NEAR(plate_pf_per_mm_with_edges(500, 0.5, 3) / plate_pf_per_mm(500, 0.5, 3), 1, 0.01);
  EXPECT_NEAR(plate_pf_per_mm_with_edges(0.9999, 1, 3) / plate_pf_per_mm_with_edges(1.0001, 1, 3), 1, 0.01);
}

TEST(SheetDielectric, IsOfTheMaterialUnlessItIsMeasured) {
  SheetSettings sheet;
  sheet.material = Material::hips;
  EXPECT_EQ(sheet_dielectric(sheet).permittivity, 2.5);
  sheet.permittivity = 2.61;
  sheet.loss_tangent = 0.0005;
  EXPECT_EQ(sheet_dielectric(sheet).permittivity, 2.61);
  EXPECT_EQ(sheet_dielectric(sheet).loss_tangent, 0.0005);
}

// Seven rings on a sphere of 90 mm that do not touch; the other face is .8 mm below.
struct Apart {
  Sample sheet = sphere(90, 440, 140);
  Sample below = sheet;
  Charted surface{sheet};
  Drawing drawing = seven_rings(22, 62);
  Settings settings;
  std::optional<BodyBelow> body = BodyBelow{{{0, 0, 0}, 88, 0}, 2};

  Apart() {
    for (Vector3d& p : below.sheet.formed) p *= 89.2 / 90;
    settings.circuit.frequency_mhz = 298.04;
    settings.coils.capacitor = CapacitorCase::printed;
    settings.coils.gaps = 3;
    settings.coils.plate_width_mm = 10;
    settings.sheet.permittivity = 6;
  }
  ArrayBuild build() {
    const Charted other(below.sheet, below.flattening);
    const auto placement = place(surface, &drawing, settings, Context());
    return *build_array(drawing, *placement, {surface, other}, body, settings, Context());
  }
};

const BuiltLayer* layer_of(const ArrayBuild& build, PrintStep step, int face) {
  for (const BuiltLayer& each : build.layers)
    if (each.step == step && each.face == face) return &each;
  return nullptr;
}

TEST(Plates, HaveTheCapacitanceThatTunesTheLoop) {
  Apart rings;
  const ArrayBuild build = rings.build();
  ASSERT_EQ(build.gaps.size(), 21u);
  for (const Warning& warning : build.warnings) EXPECT_NE(warning.code, "plates-small") << warning.text;
  const BuiltLayer* const reverse = layer_of(build, PrintStep::conductor, 1);
  ASSERT_TRUE(reverse);
  double plates_mm2 = 0, ink = 0;
  for (const LoopGap& gap : build.gaps) {
    EXPECT_EQ(gap.plate.has_value(), !gap.port);
    if (!gap.plate) continue;
    EXPECT_NEAR(gap.plate->pf / gap.plate->wanted_pf, 1, 0.001);
    EXPECT_NEAR(gap.plate->thickness_mm, 0.8, 0.01);
    // Two capacitors in series, on the part.
    const double length = (gap.plate->before + gap.plate->after) / 2;
    EXPECT_NEAR(gap.plate->between_pf, plate_pf_per_mm(10, 0.8, 6) * length / 2,
                0.02 * gap.plate->between_pf);
    EXPECT_GT(gap.plate->pf, gap.plate->between_pf);
    plates_mm2 += 10 * (gap.plate->before + gap.plate->after + gap.along.length());
  }
  for (const Element& element : reverse->drawing.elements)
    for (const Shape& shape : element.shapes) ink += ink_mm2(shape);
  EXPECT_NEAR(ink / plates_mm2, 1, 0.02);
}

TEST(Plates, SayThatTheyHaveNoRoom) {
  Apart rings;
  rings.settings.circuit.frequency_mhz = 127.74;
  rings.settings.sheet.permittivity = 3;
  const ArrayBuild build = rings.build();
  const auto small = std::find_if(build.warnings.begin(), build.warnings.end(),
                                  [](const Warning& warning) { return warning.code == "plates-small"; });
  ASSERT_NE(small, build.warnings.end());
  EXPECT_EQ(small->marks.size(), 14u);
  EXPECT_LT(small->figure->value, 98);
}

// Loops that overlap on two faces: no plate lies on another loop.
TEST(Plates, KeepAwayFromOtherLoops) {
  Apart rings;
  rings.drawing = seven_rings(30, 1.516 * 30);
  rings.settings.coils.build = CoilBuild::two_faces;
  const ArrayBuild build = rings.build();
  std::size_t found = 0;
  for (const LoopGap& gap : build.gaps) {
    if (!gap.plate) continue;
    ++found;
    const auto e = static_cast<std::size_t>(gap.coil);
    const int face = 1 - build.faces[e];
    const Area plate = [&] {
      std::vector<Ring> rings_of;
      for (const Shape& shape : layer_of(build, PrintStep::conductor, face)->drawing.elements[e].shapes)
        for (Ring& ring : stroke_area(shape.curves, *shape.stroke, 0.01)) rings_of.push_back(std::move(ring));
      return union_of(rings_of);
    }();
    for (std::size_t other = 0; other < build.faces.size(); ++other) {
      if (other == e || build.faces[other] != face) continue;
      for (const Shape& shape : layer_of(build, PrintStep::conductor, face)->drawing.elements[other].shapes)
        if (shape.stroke) {
          EXPECT_LT(square_mm(intersection(plate, stroke_area(shape.curves, *shape.stroke, 0.01))), 0.05)
              << e << " and " << other;
        }
    }
  }
  EXPECT_GT(found, 0u);
}

}  // namespace
}  // namespace vacuform
