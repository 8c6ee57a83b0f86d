// The side of the patient's left, as a person saw it on the placed mold, against what the settings say of the face.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// The warning "mirrored-or-turned" if the left that was seen is not where it must be. The face is known only where
// scan.front names its side; a mold that faces mostly along x has its left on neither side of x. Then nullopt.
std::optional<Warning> left_side_warning(const ScanSettings& settings);

}  // namespace vacuform
