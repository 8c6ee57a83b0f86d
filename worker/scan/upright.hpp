// The unit of a scan, which its file does not state, and the turn that stands it upright.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "api/base/error.hpp"
#include "api/settings.hpp"

namespace vacuform {

double millimetres(Unit unit);  // in one unit

// Whether a scan may be that large: 10 to 4000 mm.
bool usable_side(double mm);

// The unit in which the longest side measures 80 to 400 mm. Error: ambiguous_units if no unit or more than one fits. It
// names the candidates, the resulting sizes and a setting that is accepted.
Result<Unit> guess_unit(double longest_side, const std::string& where);

// If another unit would make the scan a little smaller or larger than guess_unit() accepts as plausible (a figurine or
// a large bust), one sentence for people; otherwise empty.
std::string unit_doubt(double longest_side, Unit guessed);

// The rotation that brings `up` to +z: about the single axis that needs the smallest angle. Then roll, pitch and yaw
// about the fixed axes x, y and z, in this order.
Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg);

// Where +Z of the file, which glTF defines as the front of an asset, points in the upright scan: after up, mirror, roll
// and pitch. Nothing if it points less than 45 degrees from the vertical.
std::optional<FrontSide> front_of_gltf(const ScanSettings& settings, UpAxis up);

// What the settings apply before the front: up, mirrored in x = 0, roll, pitch.
Eigen::Matrix3d turn_before_front(const ScanSettings& settings, UpAxis up);

// All that the settings apply to a scan whose up axis is known: up, mirrored in x = 0, roll, pitch, the front to +y,
// yaw.
Eigen::Matrix3d scan_turn(const ScanSettings& settings, UpAxis up);

}  // namespace vacuform
