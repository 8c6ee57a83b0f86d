// The baseline without a simulation: every vertex inside the window moves straight down to the first surface below it.
#include <algorithm>
#include <limits>

#include "worker/forming/process.hpp"

namespace vacuform {

namespace {

// Lowers the free vertices to height z, or to the surface that they meet on the way.
void lower(const Process& process, SheetState& state, double z, double from_time, double to_time) {
  Points y = state.x;
  for (std::size_t i = 0; i < state.held.size(); ++i)
    if (!state.held[i]) y(2, i) = z;
  state.land(state.landings(process, y), 1, y, from_time, to_time);
  state.x = y;
}

}  // namespace

Result<void> form_projection(const Process& process, SheetState& state, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::forming, 0));
  // Level with the frame while it descends, then down with the vacuum to the platform.
  const double frame = std::min(process.top_mm, process.machine.drape_height_mm);
  lower(process, state, frame, 0, 1);
  for (std::size_t i = 0; i < state.held.size(); ++i)
    if (process.grid.clamped[i]) state.x(2, i) = frame;
  VACUFORM_CHECK(context.step(Stage::forming, 0.5));
  constexpr double under_the_platform = -1e-3;  // so that the vertices reach the platform
  lower(process, state, under_the_platform, 1, 2);
  // Nothing moves, and no forces are computed.
  state.summary.converged = true;
  state.summary.residual = state.summary.force_error = std::numeric_limits<double>::quiet_NaN();
  return {};
}

}  // namespace vacuform
