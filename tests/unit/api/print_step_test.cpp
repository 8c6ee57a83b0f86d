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
  for (const auto* name : {"conductor", "Conductors", "SILVER", "silver ink", "Layer conductor", "print",
                           "1 conductor", "conductor-1", "CONDUCTOR_LAYER"})
    expect_layer(name, PrintStep::conductor);
  for (const auto* name : {"dielectric", "Dielectric ink", "print-dielectric", "2_insulation"})
    expect_layer(name, PrintStep::dielectric);
  for (const auto* name :
       {"bridges", "print-bridges", "jumper", "3 Crossovers", "silver 2", "second silver", "conductor2"})
    expect_layer(name, PrintStep::bridges);
}

TEST(PrintStep, IsOnAFaceThatTheLayerNames) {
  expect_layer("print-reverse", PrintStep::conductor, DrawnFace::reverse);
  expect_layer("print-reverse-dielectric", PrintStep::dielectric, DrawnFace::reverse);
  expect_layer("Conductor, inner face", PrintStep::conductor, DrawnFace::inner);
  expect_layer("outer_bridges", PrintStep::bridges, DrawnFace::outer);
}

// Other words may say anything, such as whose array it is, and a number may be that of a patient.
TEST(PrintStep, IsNothingElse) {
  for (const auto* name : {"", "Layer 1", "coil-3", "inner", "reverse", "bridge over Smith",
                           "dielectric Smith", "conductor 12345678", "dielectric 19700101", "3 silver",
                           "2 silver", "conductor dielectric", "inner outer conductor", "conductor 1 2",
                           "pr\xc3\xaent", "conductors of the back", "second", "print 2"})
    EXPECT_FALSE(drawn_layer(name)) << name;
  EXPECT_FALSE(drawn_layer(std::string(65, ' ') + "print"));
}

}  // namespace
}  // namespace vacuform
