// A JSON artifact for use by the server itself. A worker's child made it from untrusted files: it is hostile until
// parsed.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "server/store/store.hpp"

namespace vacuform {

// report.json, findings.json or layout.json of a job. Null if it is missing, cannot be read, is above 4 MiB, is not a JSON object,
// or is nested deeper than 16.
nlohmann::ordered_json json_artifact(Store& store, const Job& job, std::string_view name);

}  // namespace vacuform
