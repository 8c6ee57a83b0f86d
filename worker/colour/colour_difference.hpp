// How different two colours look to people.
#pragma once

#include <Eigen/Core>

namespace vacuform {

// L*, a* and b* of CIE 1976 under D65, 2 degree observer, from linear light of sRGB (IEC 61966-2-1), each in [0, 1].
Eigen::Vector3d lab_of(const Eigen::Vector3f& linear);

// CIEDE2000 (ISO/CIE 11664-6) between two L*a*b*, with all weights 1; about 1 is the least that people see. Formulas and
// cases of hue: G. Sharma, W. Wu, E. N. Dalal 2005, "The CIEDE2000 color-difference formula: implementation notes,
// supplementary test data, and mathematical observations".
double ciede2000(const Eigen::Vector3d& one, const Eigen::Vector3d& other);

}  // namespace vacuform
