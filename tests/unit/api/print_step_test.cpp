#include "api/print_step.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

void expect_layer(std::string_view name, PrintStep step, DrawnFace face = DrawnFace::first) {
  const auto layer = drawn_layer(name);
  ASSERT_TRUE(layer) << name;
  EXPECT_EQ(*layer, (DrawnLayer{step, face})) << name;
}

TEST(PrintStep, IsNamedByALayer) {
  for (const auto* name :
       {"conductor", "Conductors", "SILVER", "silver ink", "Layer conductor", "print", "CONDUCTOR_LAYER"})
    expect_layer(name, PrintStep::conductor);
  for (const auto* name : {"dielectric", "Dielectric ink", "print-dielectric"})
    expect_layer(name, PrintStep::dielectric);
  for (const auto* name :
       {"bridges", "print-bridges", "jumper", "Crossovers", "second silver", "Second conductor"})
    expect_layer(name, PrintStep::bridges);
}

// Drawing programs number layers of one name: conductor_2_ (Illustrator), conductor2 (Affinity), trace_2 (Graphite).
TEST(PrintStep, IsNotChangedByANumber) {
  for (const auto* name : {"1 conductor", "01 Silver", "conductor-2", "conductor_2_", "conductor2", "trace3",
                           "3 silver", "Copper side 2", "print 2"})
    expect_layer(name, PrintStep::conductor);
  expect_layer("2_insulation", PrintStep::dielectric);
  expect_layer("3 bridges_2_", PrintStep::bridges);
}

TEST(PrintStep, IsOnAFaceThatTheLayerNames) {
  expect_layer("print-reverse", PrintStep::conductor, DrawnFace::reverse);
  expect_layer("print-reverse-dielectric", PrintStep::dielectric, DrawnFace::reverse);
  expect_layer("Conductor, inner face", PrintStep::conductor, DrawnFace::inner);
  expect_layer("outer_bridges", PrintStep::bridges, DrawnFace::outer);
}

// Other words may say anything, such as whose array it is, and a number may be that of a patient.
TEST(PrintStep, IsNothingElse) {
  for (const auto* name :
       {"", "Layer 1", "coil-3", "inner", "reverse", "second", "bridge over Smith", "dielectric Smith",
        "conductor 12345678", "dielectric 19700101", "conductor dielectric", "inner outer conductor",
        "pr\xc3\xaent", "conductors of the back"})
    EXPECT_FALSE(drawn_layer(name)) << name;
  EXPECT_FALSE(drawn_layer(std::string(65, ' ') + "print"));
}

}  // namespace
}  // namespace vacuform
