// The mold of `vacuform chart`: a low pyramid of four level steps that wears patches of single inks. The sheet stretches
// more from step to step, and a step is level, so that a colorimeter can stand on it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/settings.hpp"

namespace vacuform {

// A square of one ink, its sides along x and y.
struct MoldPatch {
  std::string id;         // "C3b": cyan, the third coverage, step b from the top; "W" is bare
  int ink = -1;           // 0 cyan, 1 magenta, 2 yellow, -1: bare
  int step = 1;           // from the top
  double coverage = 0;    // 1 - linear light of the colour as its bytes have it, in [0, 1]
  Eigen::Vector3d place;  // of the middle, mm, on the mold that stands on z = 0
};

struct SteppedMold {
  std::vector<std::uint8_t> glb;
  std::vector<MoldPatch> patches;  // 16 a step: five coverages of each ink, and a bare one
  double patch_mm = 0;             // side of a patch
};

// Sized for the window of the machine. Nothing if the window is so small that patches would be smaller than 6 mm.
std::optional<SteppedMold> stepped_mold(const MachineSettings& machine);
// The smallest window that it fits into: its narrower side, or its diameter.
double least_window_mm(WindowShape window);

}  // namespace vacuform
