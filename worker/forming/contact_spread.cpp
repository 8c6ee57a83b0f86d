#include "worker/forming/contact_spread.hpp"

#include <algorithm>

namespace vacuform {

double ContactSpread::one_row(const Process& process, const SheetState& state, const Points& y,
                              const SheetAsObstacle& ceiling) {
  SheetState ahead = state;
  Points touched = y;
  if (ahead.follow(process, touched, 0, 1, &ceiling) == 0) return 1;

  struct Landing {
    double time;
    int vertex;
  };
  std::vector<Landing> landings;
  for (std::size_t i = 0; i < state.held.size(); ++i)
    if (ahead.held[i] && !state.held[i])
      landings.push_back({ahead.folded[i] ? 0.5 : ahead.time[i], static_cast<int>(i)});
  std::sort(landings.begin(), landings.end(), [](const Landing& a, const Landing& b) {
    return a.time != b.time ? a.time < b.time : a.vertex < b.vertex;
  });
  std::vector<char> landed(state.held.size(), 0);
  for (const auto& [time, vertex] : landings) {
    bool beside_held = false, beside_landed = false;
    for (const int v : fans_.around(vertex)) {
      beside_held = beside_held || state.held[v];
      beside_landed = beside_landed || landed[v];
    }
    if (beside_landed && !beside_held) return std::max(time, 0.02);
    landed[vertex] = 1;
  }
  return 1;
}

}  // namespace vacuform
