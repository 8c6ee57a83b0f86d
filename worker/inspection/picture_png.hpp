// Pictures as PNG, eight bits a channel. Internal to worker/inspection.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/inspection/view.hpp"

namespace vacuform {

std::vector<std::uint8_t> png_of(const Picture& picture);

}  // namespace vacuform
