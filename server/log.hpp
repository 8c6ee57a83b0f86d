// The server's log: one JSON object a line on stderr. It names jobs by their ids and routes by their
// patterns; names of files, settings, addresses and tokens never reach it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace vacuform {

// log_event("job-created", {{"job", id}}) writes {"time": ..., "event": "job-created", "job": ...}.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

}  // namespace vacuform
