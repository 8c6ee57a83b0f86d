// The findings of the scan stage as JSON: the same keys in report.json and in `vacuform inspect --json`.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "worker/scan/mold.hpp"

namespace vacuform {

nlohmann::ordered_json scan_json(const ScanFindings& findings);
// Size, top and the twenty deepest undercuts (deepest first: the rest is small beside them). Lengths in mm.
nlohmann::ordered_json mold_json(const Mold& mold);

}  // namespace vacuform
