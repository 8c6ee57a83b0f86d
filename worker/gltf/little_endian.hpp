// Numbers as little-endian bytes.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace vacuform {

inline void append(std::vector<std::uint8_t>& out, std::uint32_t bits) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(bits >> shift));
}
// As a float.
inline void append(std::vector<std::uint8_t>& out, double value) {
  append(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace vacuform
