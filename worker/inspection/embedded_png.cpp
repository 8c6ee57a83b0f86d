#include <algorithm>

#include "worker/inspection/report_html.hpp"
#include "worker/inspection/shrunk_png.hpp"

namespace vacuform {

namespace {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace

std::string embedded_png(const std::vector<std::uint8_t>& png, int width, int skipped) {
  return base64(shrunk_png(png, width, skipped, false));
}

}  // namespace vacuform
