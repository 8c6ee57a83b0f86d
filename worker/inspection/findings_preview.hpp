// preview-findings.png: where to look before forming. Internal to worker/inspection.
#pragma once

#include <vector>

#include "worker/inspection/view.hpp"

namespace vacuform {

inline constexpr int preview_side =
    1000;  // pixels of a preview's width, and of the height of a picture with its caption

const Rgb plastic(0.90f, 0.925f, 0.945f);
// The colour of a sample of the part without ink.
Rgb bare(const Seen& seen);

// The marks of the warnings on `front`, a picture of the bare part that `view` drew. Marks that are seen better from
// behind are on a second picture below. Errors: cancelled.
Result<Picture> findings_preview(const std::vector<Warning>& warnings, View& view, Picture&& front,
                                 const Context& context);

// The same on the mold, before any sheet is formed over it. Errors: cancelled.
Result<Picture> findings_preview(const Mold& mold, const Context& context);

}  // namespace vacuform
