#include "api/print_step.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

void expect_layer(std::string_view name, PrintStep step, DrawnFace face = DrawnFace::first,
                  bool openings = false) {
  const auto layer = drawn_layer(name);
  ASSERT_TRUE(layer) << name;
  EXPECT_EQ(*layer, (DrawnLayer{step, face, openings})) << name;
}

TEST(PrintStep, IsNamedByALayer) {
  for (const auto* name : {"conductor", "Conductors", "SILVER", "silver ink", "Layer conductor",
                           "Conductive ink", "print", "CONDUCTOR_LAYER"})
    expect_layer(name, PrintStep::conductor);
  for (const auto* name : {"dielectric", "Dielectric ink", "insulating layer 2", "print-dielectric"})
    expect_layer(name, PrintStep::dielectric);
  for (const auto* name :
       {"bridges", "print-bridges", "jumper", "Crossovers", "second silver", "Second conductor"})
    expect_layer(name, PrintStep::bridges);
  for (const auto* name :
       {"resist", "print-resist", "Solder resist", "Varnish", "soldermask", "SOLDER MASK", "solder_mask_2",
        "Solder mask resist", "cover", "Overcoat", "encapsulant ink", "solderresist"})
    expect_layer(name, PrintStep::resist);
  for (const auto* name : {"picture", "print-picture", "Artwork", "Graphics", "image", "Decoration",
                           "colour layer", "colors", "Legend", "silkscreen"})
    expect_layer(name, PrintStep::picture);
}

// Drawing programs number layers of one name: conductor_2_ (Illustrator), conductor2 (Affinity), trace_2 (Graphite).
TEST(PrintStep, IsNotChangedByANumber) {
  for (const auto* name : {"1 conductor", "01 Silver", "conductor-2", "conductor_2_", "conductor2", "trace3",
                           "3 silver", "Copper side 2", "print 2"})
    expect_layer(name, PrintStep::conductor);
  expect_layer("2_insulation", PrintStep::dielectric);
  expect_layer("3 bridges_2_", PrintStep::bridges);
  expect_layer("4 resist", PrintStep::resist);
  expect_layer("05_picture_2_", PrintStep::picture);
}

TEST(PrintStep, IsOnAFaceThatTheLayerNames) {
  expect_layer("print-reverse", PrintStep::conductor, DrawnFace::reverse);
  expect_layer("print-reverse-dielectric", PrintStep::dielectric, DrawnFace::reverse);
  expect_layer("Conductor, inner face", PrintStep::conductor, DrawnFace::inner);
  expect_layer("outer_bridges", PrintStep::bridges, DrawnFace::outer);
  expect_layer("print-reverse-resist", PrintStep::resist, DrawnFace::reverse);
  expect_layer("Picture, outer face", PrintStep::picture, DrawnFace::outer);
}

TEST(PrintStep, OfResistMayBeItsOpenings) {
  expect_layer("resist openings", PrintStep::resist, DrawnFace::first, true);
  expect_layer("solder mask opening inner", PrintStep::resist, DrawnFace::inner, true);
}

// As KiCad and the plug-ins for Inkscape name them: a mask shows what it leaves open.
TEST(PrintStep, IsNamedAsOnABoard) {
  expect_layer("F.Cu", PrintStep::conductor);
  expect_layer("B.Cu", PrintStep::conductor, DrawnFace::reverse);
  expect_layer("F.SilkS", PrintStep::picture);
  expect_layer("B.Silkscreen", PrintStep::picture, DrawnFace::reverse);
  expect_layer("F.Mask", PrintStep::resist, DrawnFace::first, true);
  expect_layer("B_Mask", PrintStep::resist, DrawnFace::reverse, true);
  expect_layer("F.Mask-invert", PrintStep::resist);
  for (const auto* name : {"F.Cu-disabled", "F.Mask-auto", "F.Paste", "In1.Cu", "Edge.Cuts", "F.Silver",
                           "conductor b", "F.B.Cu", "F.Fab"})
    EXPECT_FALSE(drawn_layer(name)) << name;
}

TEST(PrintStep, ConductsOrPartsOrCovers) {
  EXPECT_TRUE(conducts(PrintStep::conductor) && conducts(PrintStep::bridges));
  EXPECT_FALSE(conducts(PrintStep::dielectric) || conducts(PrintStep::resist) ||
               conducts(PrintStep::picture));
  EXPECT_TRUE(of_circuits(PrintStep::dielectric));
  EXPECT_FALSE(of_circuits(PrintStep::resist) || of_circuits(PrintStep::picture));
}

// Other words may say anything, such as whose array it is, and a number may be that of a patient.
TEST(PrintStep, IsNothingElse) {
  for (const auto* name : {"",
                           "Layer 1",
                           "coil-3",
                           "inner",
                           "reverse",
                           "second",
                           "bridge over Smith",
                           "dielectric Smith",
                           "conductor 12345678",
                           "dielectric 19700101",
                           "conductor dielectric",
                           "inner outer conductor",
                           "pr\xc3\xaent",
                           "conductors of the back",
                           "mask",
                           "solder",
                           "solder paste",
                           "mask print",
                           "openings",
                           "conductor openings",
                           "picture of Mary Smith",
                           "image 1234",
                           "resist invert",
                           "cover picture"})
    EXPECT_FALSE(drawn_layer(name)) << name;
  EXPECT_FALSE(drawn_layer(std::string(65, ' ') + "print"));
}

}  // namespace
}  // namespace vacuform
