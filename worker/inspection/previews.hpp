// The pictures of a finished job. Internal to worker/inspection.
#pragma once

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/sheet_picture.hpp"

namespace vacuform {

// preview-pattern.png, preview-print.png: the drawing, and the print on the flat sheet (flat_previews.hpp).
// preview-without.png: the drawing as it would come out if it were printed as it is, its centre on the point
// of the sheet that comes to lie on the top of the mold. preview-with.png: the pre-distorted print.
// The heat maps of heat_maps.hpp. preview-findings.png: the bare sheet with the marks of the warnings of
// scan, forming and of stretched traces. preview-segments.png, where the drawing is laid in segments. `print`: of the
// job.
Result<std::vector<Artifact>> previews(const Finished& job, const SheetPicture& print,
                                       const Context& context);

}  // namespace vacuform
