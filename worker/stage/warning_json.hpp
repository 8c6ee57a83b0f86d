// Warnings as they are in report.json and in the findings of an inspection.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/job.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

// {stage, code, severity, what, place, figure, fix, marks}. `place` is in words, `figure` {value, unit, limit} or null.
nlohmann::ordered_json warning_json(Stage stage, const Warning& warning);

}  // namespace vacuform
