// The height at which a closed, upright scan is cut, and what its undercuts are above it.
#pragma once

#include <optional>

#include "worker/scan/mold.hpp"
#include "worker/scan/scan_progress.hpp"

namespace vacuform {

struct Trim {
  double height_mm = 0;             // above the scan's lowest point
  std::vector<Undercut> undercuts;  // above it and worth a report, deepest first; places above the cut
  std::optional<Warning> warning;   // trim-discards; its mark is a place on the cut
};

// The height that was given, or the lowest that leaves no undercut, by the limits that mold.hpp names. `closed` stands on
// z = 0 (what lies below does not count) and its principal axes lie along x and y; `from_file` turned the file's axes to
// its own. Errors: cancelled; unusable_scan where less than a twentieth of the height would be left, with a trim and, if
// there is one, an up axis that leave more.
Result<Trim> choose_trim(const TriangleMesh& closed, const ScanSettings& settings,
                         const ScanFindings& findings, const Eigen::Matrix3d& from_file,
                         const std::string& file_name, const ScanProgress& progress);

}  // namespace vacuform
