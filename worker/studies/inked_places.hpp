// Where points of the flat sheet lie once it is formed, on the face that carries the ink.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/settings.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// x, y, z of each point one after the other, mm; NaN for a point that is off the sheet. A smooth surface bulges out
// from the chords of its triangles (19 um on a head with a grid of 3 mm), so the interpolation is quadratic: it moves
// each corner of the triangle along half its gradient and weights the results linearly, which is exact for quadratic
// surfaces.
Eigen::VectorXd inked_places(const FormedSheet& sheet, InkedFace face,
                             const std::vector<Eigen::Vector2d>& rest);

}  // namespace vacuform
