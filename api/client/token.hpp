// Where a program reads its token for a server. Never from the command line, which every user of the machine can read.
#pragma once

#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// The first line of the file, else the environment's VACUFORM_TOKEN, else the first line of the file that
// VACUFORM_TOKEN_FILE names; empty without any of them. Errors: unreadable (a named file cannot be read, or its first
// line is empty).
Result<std::string> find_token(const std::string& file);

}  // namespace vacuform
