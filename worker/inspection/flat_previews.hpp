// preview-pattern.png, preview-lengths.png and preview-print.png: the drawing, how long its lines come out, and the print
// on the flat sheet with the areas that forming uses. Internal to worker/inspection.
#pragma once

#include "worker/inspection/sheet_picture.hpp"
#include "worker/inspection/view.hpp"

namespace vacuform {

// The drawing on its page, with a scale.
Picture pattern_preview(const Finished& job, int side);

// The lines of the drawing on its page, coloured by how much longer or shorter they come out; the worst lie on top.
Picture lengths_preview(const Finished& job, int side);

// The whole sheet as it is printed (mirrored if the print is), with the part that lands on the mold tinted, and the
// window of the frame.
Picture print_preview(const Finished& job, const SheetPicture& print, int side);

}  // namespace vacuform
