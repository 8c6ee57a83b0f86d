// The loops of a print as circuits, as in report.json. Internal to worker/inspection.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// What check_conductors() found, and what the array was built of: the face of each loop, its gaps from the port on, and
// bridges. Null without loops.
nlohmann::ordered_json circuits_json(const Finished& job);

}  // namespace vacuform
