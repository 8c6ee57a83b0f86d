// The turn that stands a scan upright, and the front that glTF defines.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "api/settings.hpp"

namespace vacuform {

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
