// The worker's log: one JSON object a line on stderr. It names jobs by their ids; names of files and tokens never
// reach it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace vacuform {

// log_event("leased", {{"job", id}}) writes {"time": ..., "event": "leased", "job": ...}. From any thread.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

}  // namespace vacuform
