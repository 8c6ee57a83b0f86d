#include "worker/scan/sides.hpp"

namespace vacuform {

SideLetters side_letters(LeftSide left) {
  switch (left) {
    case LeftSide::minus_x:
      return {"L", "R", "A", "P", "H"};
    case LeftSide::plus_x:
      return {"R", "L", "A?", "P?", "H"};
    case LeftSide::unknown:
      break;
  }
  return {"L?", "R?", "A?", "P?", "H"};
}

std::vector<Warning> side_warnings(const ScanFindings& findings) {
  if (findings.left_side == LeftSide::minus_x) return {};
  if (findings.left_side == LeftSide::plus_x)
    return {Warning{.code = "mirrored-or-turned",
                    .text = "The patient's left was seen at +x, but with the face at +y it must be at -x",
                    .place = "the whole scan"}};
  const std::string text =
      findings.left_from_file ? "Nobody has compared left and right with the patient; face and left are "
                                "placed as the file says (SPACE=" +
                                    std::string(name(findings.space)) + ")"
      : findings.front_assumed
          ? "Nobody has said where the face and the patient's left are; the face is taken to be at +y and "
            "the left "
            "at -x"
          : "Nobody has compared left and right with the patient; the left is taken to be at -x";
  return {Warning{.code = "side-unconfirmed", .text = text, .place = "the whole scan"}};
}

}  // namespace vacuform
