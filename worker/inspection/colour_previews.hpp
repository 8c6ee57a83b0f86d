// preview-original.png and preview-align.png: the formed part beside the scan whose colours it wears, and the part that
// comes out if the print lies off its registration marks. Internal to worker/inspection.
#pragma once

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/view.hpp"

namespace vacuform {

// The colour of a sample of the formed part, with the print moved by `shift` on the flat sheet, mm.
using ShadeShifted = std::function<void(const Seen&, const Eigen::Vector2d& shift, Rgb*)>;

// The scan above the platform on the left and the part on the right, from five sides, under the same light and at the
// same scale. `formed` are the five tiles of the part (tiles.hpp), `view` the view that drew them. Errors: cancelled.
Result<Picture> original_preview(const Finished& job, const View& view, const std::vector<Picture>& formed,
                                 const Context& context);

// The part in register and with each of the errors of registration, on the left from the side on which they change most,
// on the right near that place. Leaves the view with another side and frame. Errors: cancelled.
Result<Picture> align_preview(const Finished& job, View& view, const ShadeShifted& shade,
                              const Context& context);

}  // namespace vacuform
