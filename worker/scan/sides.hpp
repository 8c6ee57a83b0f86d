// Which side of the placed mold is which side of the patient. This is the one definition: the face is at +y of the mold,
// the crown at +z, and the patient's left at -x. Pictures, marks of the print, regions of a layout, the report and the page
// use it. scan.front, scan.yaw_deg and scan.mirror bring a scan there (docs/how-to/scan.md).
#pragma once

#include <string>
#include <vector>

#include "worker/scan/mold.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// What is written at each side in pictures and on the print: R, L, A (anterior, the face), P (posterior) and H (head, the
// crown). A question mark follows until a person has seen the patient's left at -x. Seen at +x, L and R change places, and
// A and P stay in doubt. web/src/scene/machine.ts has the same letters.
struct SideLetters {
  std::string minus_x, plus_x, plus_y, minus_y, plus_z;
};
SideLetters side_letters(LeftSide left);

// "side-unconfirmed" if no person has seen the patient's left (scan.left_side); "mirrored-or-turned" if it was seen at +x.
std::vector<Warning> side_warnings(const ScanFindings& findings);

}  // namespace vacuform
