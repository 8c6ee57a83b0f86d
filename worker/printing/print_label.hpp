// The texts on a print that say which job it belongs to, and which side of it is which side of the patient.
#pragma once

#include <string>

#include "worker/scan/sides.hpp"

namespace vacuform {

struct PrintLabel {
  std::string job;             // the digest of its inputs
  std::string reference = {};  // UTF-8; may be empty
  SideLetters sides = {};      // empty letters: none are printed
};

}  // namespace vacuform
