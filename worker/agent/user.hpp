// Drops the rights of root and becomes an unprivileged user.
#pragma once

#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// Creates the folder `work` and its parents if they are absent, and makes it the current directory, so that it stays
// reachable even if the user may not enter a parent folder. Then becomes the user `name` permanently. An empty name
// keeps the current user, who must then own the folder. Needs root, unless the process already runs as that user. Call
// it before any thread starts, and open what only root may open before it. Errors: bad_usage (the user does not exist,
// or not root); unreadable (the folder).
Result<void> settle(const std::string& work, const std::string& name);

}  // namespace vacuform
