// Where a program finds the token that it shows to a server. Never on a command line, which every user of the machine
// can read.
#pragma once

#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// The first line of the file, else the environment's VACUFORM_TOKEN, else the first line of the file that
// VACUFORM_TOKEN_FILE names; empty when there is none of them. Errors: unreadable (a named file cannot be read, or its
// first line is empty).
Result<std::string> find_token(const std::string& file);

}  // namespace vacuform
