// What a scan file does not tell: its unit and which way is up.
#pragma once

#include <string>

#include "api/settings.hpp"
#include "worker/scan/triangle_mesh.hpp"

namespace vacuform {

double millimetres(Unit unit);  // in one unit

// The unit in which the longest side measures 80 to 400 mm. Error: ambiguous_units when none does or more than one,
// naming the candidates, the sizes that they would give and the setting.
Result<Unit> guess_unit(double longest_side, const std::string& where);

struct UpGuess {
  UpAxis axis = UpAxis::plus_z;
  bool told = false;  // the shape told; otherwise the axis is the format's or +z
  std::string why;    // one clause for people
};

// Looks for the side on which a scan stands, in this order:
// 1. an opening: the missing face of an open skin (the sum of all area vectors points away from it);
// 2. a flat cut: the side of the bounding box in whose plane most of the skin lies;
// 3. otherwise nothing tells: +z, or +y where the format says so.
UpGuess guess_up(const TriangleMesh& skin, bool y_up);

// The turn that brings `up` to +z: about the single axis that needs the least turn. Then roll, pitch and yaw about the
// fixed axes x, y and z, in this order.
Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg);

}  // namespace vacuform
