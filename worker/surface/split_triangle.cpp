#include "worker/surface/split_triangle.hpp"

#include <algorithm>

namespace vacuform {

std::vector<Triangle> pieces_of(const Triangle& corners, const std::array<int, 3>& middles) {
  const auto split = std::count_if(middles.begin(), middles.end(), [](int v) { return v >= 0; });
  const auto first = [&](auto wanted) {
    return static_cast<std::size_t>(std::find_if(middles.begin(), middles.end(), wanted) - middles.begin());
  };
  if (split == 0) return {corners};
  // Turned so that the only side that is split, or the only one that is not, is the first.
  const bool one_whole = split == 2;
  const std::size_t k = split == 3 ? 0 : first([&](int v) { return (v < 0) == one_whole; });
  const auto turned = [k](const std::array<int, 3>& of) {
    return Triangle{of[k], of[(k + 1) % 3], of[(k + 2) % 3]};
  };
  const auto [a, b, c] = turned(corners);
  const auto [ab, bc, ca] = turned(middles);
  if (split == 1) return {{a, ab, c}, {ab, b, c}};
  if (split == 2) return {{a, b, bc}, {a, bc, ca}, {ca, bc, c}};
  return {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
}

}  // namespace vacuform
