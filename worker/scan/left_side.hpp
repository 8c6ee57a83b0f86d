// Compares the side of the patient's left, as a person saw it on the placed mold, with the side that the settings
// imply.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// The warning "mirrored-or-turned" if left is not on the side where it must be. Nullopt if scan.front does not name the
// side of the face, or if the mold faces mostly along x, so that its left is on neither side of x.
std::optional<Warning> left_side_warning(const ScanSettings& settings);

}  // namespace vacuform
