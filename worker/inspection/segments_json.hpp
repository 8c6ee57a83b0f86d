// Segments and their seams as in report.json. Internal to worker/inspection.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "worker/printing/print.hpp"

namespace vacuform {

// `segments` with distortion and area, in the order of Placement::charts; `seams` refer to them by number, counted from
// 1.
nlohmann::ordered_json segments_json(const Placement& placement, const Print& print);

}  // namespace vacuform
