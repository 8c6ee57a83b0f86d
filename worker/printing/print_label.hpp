// The texts on a print that say which job it belongs to.
#pragma once

#include <string>

namespace vacuform {

struct PrintLabel {
  std::string job;             // the digest of its inputs
  std::string reference = {};  // UTF-8; may be empty
};

}  // namespace vacuform
