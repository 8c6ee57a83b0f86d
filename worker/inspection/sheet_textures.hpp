// The flat sheet as textures for the formed one: what is printed on it, unmirrored, as PNG, RGB, on white. Both cover
// what print.png covers, with the back of the sheet (+t) at the top. Internal to worker/inspection.
#pragma once

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/sheet_picture.hpp"

namespace vacuform {

// Pixels on the longer side; fewer if the print has fewer.
inline constexpr int largest_texture = 2048;

// print.png, reduced, with its marks. With `over` the print as it shows there, without marks.
std::vector<std::uint8_t> print_texture(const Finished& job, const SheetPicture* over);
// The plain drawing at 1:1, its centre where the top of the mold comes to lie. With `over` it lies over the colours of
// the scan. Errors: cancelled.
Result<std::vector<std::uint8_t>> drawing_texture(const Finished& job, const SheetPicture* over,
                                                  const Context& context);

// Where a point of the sheet lies on them, as glTF counts: from the left and from the top, in [0, 1].
Eigen::Vector2d texture_place(const Print& print, const Eigen::Vector2d& rest);

}  // namespace vacuform
