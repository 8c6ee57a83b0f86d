#include "worker/scan/left_side.hpp"

#include <cmath>

namespace vacuform {

std::optional<Warning> left_side_warning(const ScanSettings& settings) {
  if (settings.left_side == LeftSide::unknown || settings.front == FrontSide::automatic) return std::nullopt;
  // A person who faces +y with the head up has the left hand at -x; the yaw turns both about z.
  const double left_x = -std::cos(settings.yaw_deg * M_PI / 180);
  if (std::abs(left_x) < 0.5) return std::nullopt;
  const bool expected_plus = left_x > 0;
  if (expected_plus == (settings.left_side == LeftSide::plus_x)) return std::nullopt;
  const char* const seen = expected_plus ? "-x" : "+x";
  const char* const must = expected_plus ? "+x" : "-x";
  Warning warning{.code = "mirrored-or-turned",
                  .text = std::string("The patient's left was seen at ") + seen +
                          ", but for the face that scan.front names it must be at " + must,
                  .place = "the whole scan"};
  return warning;
}

}  // namespace vacuform
