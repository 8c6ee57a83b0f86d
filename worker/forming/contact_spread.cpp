#include "worker/forming/contact_spread.hpp"

#include <algorithm>

namespace vacuform {

double ContactSpread::one_row(const SheetState& state, std::vector<SheetState::Landing> landings) const {
  const auto time = [](const SheetState::Landing& l) { return l.with == Contact::free ? 0.5 : l.part; };
  std::stable_sort(landings.begin(), landings.end(),
                   [&](const auto& a, const auto& b) { return time(a) < time(b); });
  std::vector<char> landed(state.held.size(), 0);
  for (const auto& landing : landings) {
    bool beside_held = false, beside_landed = false;
    for (const int v : fans_.around(landing.vertex)) {
      beside_held = beside_held || state.held[v];
      beside_landed = beside_landed || landed[v];
    }
    if (beside_landed && !beside_held) return std::max(time(landing), 0.02);
    landed[landing.vertex] = 1;
  }
  return 1;
}

}  // namespace vacuform
