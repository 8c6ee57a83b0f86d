// The turn that stands a scan upright, and the sides that a format or a file defines.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "api/base/patient_space.hpp"
#include "api/settings.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// The rotation that brings `up` to +z: about the single axis that needs the smallest angle. Then roll, pitch and yaw
// about the fixed axes x, y and z, in this order.
Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg);

// The side of the upright scan to which a direction of the file points: after up, mirror, roll and pitch. glTF defines +Z
// as the front of an asset, and the axes of a patient define front and left. Nothing if it points less than 45 degrees
// from the vertical.
std::optional<FrontSide> side_of(const ScanSettings& settings, UpAxis up, const Eigen::Vector3d& direction);

// The directions of the patient in the axes that a file names.
struct PatientAxes {
  Eigen::Vector3d left, front, head;
};
PatientAxes axes_of(PatientSpace space);

// The warning "space-contradicted", where the settings place the patient otherwise than the axes that the file names: by
// more than 50 degrees.
std::optional<Warning> contradicted_space(PatientSpace space, const ScanSettings& settings, UpAxis up);

// What the settings apply before the front: up, mirrored in x = 0, roll, pitch.
Eigen::Matrix3d turn_before_front(const ScanSettings& settings, UpAxis up);

// All that the settings apply to a scan whose up axis is known: up, mirrored in x = 0, roll, pitch, the front to +y,
// yaw.
Eigen::Matrix3d scan_turn(const ScanSettings& settings, UpAxis up);

}  // namespace vacuform
