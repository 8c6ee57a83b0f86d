// Where a formed sheet was too cold or too hot.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// Warnings about the temperatures of a formed sheet: "too-cold" and "too-hot", with the worst places, where the plastic
// is outside its forming window. The part in the clamp frame is not checked.
std::vector<Warning> temperature_findings(const FormedSheet& sheet, Material material);

}  // namespace vacuform
