// A formed test grid and its measured points.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "api/settings.hpp"

namespace vacuform {

struct MeasuredPoint3 {
  Eigen::Vector2d rest;   // (s, t) on the flat sheet, mm
  Eigen::Vector3d place;  // as measured, mm, in the frame of the measuring machine
};

// CSV, one point a line: s, t, x, y, z in mm, in the order of the header on the first line (other columns are skipped).
// Separated by commas, semicolons (then with decimal commas, if any) or tabs; '#' begins a remark. At least ten points,
// which must lie on the sheet and not on one line. Errors name the line: corrupt_file; too_large above 100,000 points.
Result<std::vector<MeasuredPoint3>> read_measured_grid(std::span<const std::uint8_t> bytes,
                                                       const std::string& file_name,
                                                       const SheetSettings& sheet);

}  // namespace vacuform
