// Coils, pairs and traces as in report.json. Internal to worker/inspection.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "worker/inspection/coil_figures.hpp"
#include "worker/inspection/stretched_traces.hpp"

namespace vacuform {

nlohmann::ordered_json coils_json(const CoilTable& table);
nlohmann::ordered_json pairs_json(const CoilTable& table);
// The summary of one way; null if no coil lies on the head.
nlohmann::ordered_json summary_json(const CoilTable& table, Way way);
// k of every two coils on the head, printed with pre-distortion: {coils: ids, k: one row a coil, 1 on the diagonal}.
// Null for fewer than two coils, and for more than most_coupled_coils.
nlohmann::ordered_json couplings_json(const CoilTable& table);
nlohmann::ordered_json traces_json(const TraceFigures& figures);

}  // namespace vacuform
