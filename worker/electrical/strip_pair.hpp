// Two parallel strips side by side as a line.
#pragma once

namespace vacuform {

// Inductance of a millimetre of both together, nH, of thin strips of equal width in one plane, with the current at their edges as
// at high frequency: mu0 K(k) / K(k'), k = between / (between + 2 width), k'^2 = 1 - k^2, K the complete elliptic integral of
// the first kind (coplanar strips: Wen, IEEE Trans. MTT-17, 1969, by conformal mapping; Wadell, Transmission Line Design Handbook,
// 1991). Sizes in mm, above 0.
double strip_pair_nh_per_mm(double width_mm, double between_mm);

}  // namespace vacuform
