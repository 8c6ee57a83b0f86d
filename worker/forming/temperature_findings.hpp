// Where a formed sheet was too cold or too hot.
#pragma once

#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace vacuform {

// What a maker must be told of the temperatures of a formed sheet: "too-cold" and "too-hot", with the worst places, where
// the plastic is outside of its forming window. What the clamp frame holds is not looked at.
std::vector<Warning> temperature_findings(const FormedSheet& sheet, Material material);

}  // namespace vacuform
