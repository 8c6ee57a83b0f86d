// A PNG reduced to the size at which it is shown. Internal to worker/inspection.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/png/png_writer.hpp"

namespace vacuform {

// At most `width` pixels wide, its height in proportion, without its first `skipped` rows, as RGB on white: each pixel
// is the mean of what it covers. `mirrored` swaps left and right. Memory is a few rows, for any size. Empty if the
// bytes are not a PNG that is written row by row.
std::vector<std::uint8_t> shrunk_png(const std::vector<std::uint8_t>& png, int width, int skipped,
                                     bool mirrored);

}  // namespace vacuform
