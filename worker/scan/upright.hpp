// Properties that a scan file does not state: its unit and which way is up.
#pragma once

#include <optional>
#include <string>

#include "api/settings.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

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

struct UpGuess {
  UpAxis axis = UpAxis::plus_z;
  bool conclusive = false;  // the shape was conclusive; otherwise the user must check
  std::string why;          // one clause for people
};

// Looks for the side on which a scan, about 200 mm long, stands, in this order:
// 1. an opening: the missing face of an open skin (the sum of all area vectors points away from it), if it covers at
//    least 12 % of the box seen from below;
// 2. a flat cut: the side of the bounding box in whose plane most of the skin lies, if no other has half as much;
// 3. otherwise the axis along which most can be formed: the height of the mold that an automatic trim leaves, times the
//    share of it that is a dome (a skull, not a face). +z and +y, which exporters use, get an advantage of a fifth. If
//    a body has several flat sides, only those are compared;
// 4. +z if no axis leaves a mold.
// The last two are guesses, and so is every result for a broken skin. An opening is only used if one border makes up
// most of it, because the holes of a broken skin point anywhere. Without one, the guess about a broken skin is made
// from a wrap around it. Error: cancelled.
Result<UpGuess> guess_up(const TriangleMesh& skin, const ScanProgress& progress);

// The rotation that brings `up` to +z: about the single axis that needs the smallest angle. Then roll, pitch and yaw
// about the fixed axes x, y and z, in this order.
Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg);

// Where +Z of the file, which glTF defines as the front of an asset, points in the upright scan: after up, mirror, roll
// and pitch. Nothing if it points less than 45 degrees from the vertical.
std::optional<FrontSide> front_of_gltf(const ScanSettings& settings, UpAxis up);

// All that the settings apply to a scan whose up axis is known: up, mirrored in x = 0, roll, pitch, the front to +y,
// yaw.
Eigen::Matrix3d scan_turn(const ScanSettings& settings, UpAxis up);

}  // namespace vacuform
