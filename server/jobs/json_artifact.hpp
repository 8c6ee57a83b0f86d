// A JSON artifact for the server's own use. A worker's child made it from somebody's files: it is hostile until parsed.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "server/store/store.hpp"

namespace vacuform {

// report.json or findings.json of a job. Null when there is none, it cannot be read, is above 4 MiB, no JSON object, or
// nested deeper than 16.
nlohmann::ordered_json json_artifact(Store& store, const Job& job, std::string_view name);

}  // namespace vacuform
