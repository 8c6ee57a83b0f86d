// The ids of jobs: 26 characters of Crockford's base 32, 48 bits of time and 80 random ones. They sort by
// time, and nobody can guess one.
#pragma once

#include <string>

#include "api/base/clock.hpp"

namespace vacuform {

std::string make_job_id(Millis time);
// The least id of that time.
std::string first_job_id(Millis time);

}  // namespace vacuform
