// The one place that reads the clock.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace vacuform {

using Millis = std::int64_t;  // milliseconds since 1970-01-01T00:00:00Z
using Clock = std::function<Millis()>;

Millis wall_clock();
// Milliseconds since this machine was started, asleep or awake: for spans of time, which no setting of the clock changes.
Millis boot_clock();
// "2026-01-31T12:00:00.123Z" (RFC 3339).
std::string rfc3339(Millis time);
// The time of a text as RFC 3339 has it, with any offset, to the millisecond; nothing if it is not one.
std::optional<Millis> from_rfc3339(const std::string& text);

}  // namespace vacuform
