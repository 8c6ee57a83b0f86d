#include "worker/scan/scan_colours.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace vacuform {

float linear_from_srgb(float encoded) {
  const float x = std::clamp(encoded, 0.0f, 1.0f);
  return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
}

float srgb_from_linear(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

namespace {

// Where each byte begins, and the byte at the start of each of many equal steps of linear light. No step holds more than
// two bytes.
struct SrgbBytes {
  static constexpr int steps = 4096;
  std::array<float, 256> begin{};
  std::array<std::uint8_t, steps + 1> first{};

  SrgbBytes() {
    const auto byte = [](float x) { return std::lround(srgb_from_linear(x) * 255); };
    for (std::size_t k = 1; k < begin.size(); ++k) {
      // Floats above 0 are in the order of their bits.
      auto low = std::bit_cast<std::uint32_t>(0.0f), high = std::bit_cast<std::uint32_t>(1.0f);
      while (high - low > 1) {
        const std::uint32_t middle = low + (high - low) / 2;
        (byte(std::bit_cast<float>(middle)) >= static_cast<long>(k) ? high : low) = middle;
      }
      begin[k] = std::bit_cast<float>(high);
    }
    for (std::size_t i = 0; i < first.size(); ++i)
      first[i] = static_cast<std::uint8_t>(byte(static_cast<float>(i) / steps));
  }
};

}  // namespace

std::uint8_t srgb_byte(float linear) {
  static const SrgbBytes bytes;
  const float x = std::clamp(linear, 0.0f, 1.0f);
  std::uint8_t k = bytes.first[x * SrgbBytes::steps];
  while (k < 255 && x >= bytes.begin[k + 1u]) ++k;
  return k;
}

}  // namespace vacuform
