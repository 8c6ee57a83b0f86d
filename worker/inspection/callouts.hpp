// preview-findings.png: warnings with a place, as numbered marks on a look at the formed sheet, with a legend. Internal
// to worker/inspection.
//
// Each code has a shape and a colour of its own; the colours are those of Okabe and Ito ("Color universal design", 2008),
// which people without full colour vision tell apart. A mark's number is its place in the warning's list, worst first; a
// ring shows its size, dashed where the sheet hides it.
#pragma once

#include <vector>

#include "worker/context.hpp"
#include "worker/inspection/view.hpp"

namespace vacuform {

// Draws the marks of the warnings that have any (all vents, of others the six worst: more would hide the part) onto the picture that `view` drew, writes the title, and lets the picture
// grow downwards by a legend in the place of its lower caption.
void draw_callouts(const View& view, const std::vector<Warning>& warnings, Picture& picture);

}  // namespace vacuform
