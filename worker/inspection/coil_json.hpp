// Coils, pairs and traces as they stand in report.json. Internal to worker/inspection.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "worker/inspection/coil_figures.hpp"
#include "worker/inspection/stretched_traces.hpp"

namespace vacuform {

nlohmann::ordered_json coils_json(const CoilTable& table);
nlohmann::ordered_json pairs_json(const CoilTable& table);
nlohmann::ordered_json summary_json(const CoilSummary& summary);
nlohmann::ordered_json traces_json(const TraceFigures& figures);

}  // namespace vacuform
