// Giving up root's rights for those of a user without any.
#pragma once

#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// Makes the folder `work` and what is above it where they are absent, and goes into it, so that it is in reach from then on
// even where the user may not enter a folder above it. Then becomes the user `name`, for good; an empty name: stays who it is,
// and then the folder must be this user's own. Needs root, unless it is that user already. Call it before any thread is
// started, and open before it what only root may open. Errors: bad_usage (there is no such user, or not root); unreadable (the
// folder).
Result<void> settle(const std::string& work, const std::string& name);

}  // namespace vacuform
