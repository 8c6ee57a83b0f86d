// The one place that reads the clock.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace vacuform {

using Millis = std::int64_t;  // milliseconds since 1970-01-01T00:00:00Z
using Clock = std::function<Millis()>;

Millis wall_clock();
// "2026-01-31T12:00:00.123Z" (RFC 3339).
std::string rfc3339(Millis time);

}  // namespace vacuform
