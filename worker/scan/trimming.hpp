// The height at which a closed, upright scan is cut, and its undercuts above the cut.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "worker/scan/mold.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/scan/scan_progress.hpp"

namespace vacuform {

struct Trim {
  double height_mm = 0;             // above the scan's lowest point
  std::vector<Undercut> undercuts;  // above it and worth a report, deepest first; places above the cut
  std::optional<Warning> warning;   // trim-discards; its mark is a place on the cut
};

// Whether a closed mesh can be cut at a height and the part above it is a mold.
using CanCut = std::function<bool(const TriangleMesh& closed, double height_mm)>;

// The given height, or the lowest one without undercuts, by the limits in mold.hpp. `closed` stands on z = 0 (anything
// below is ignored) and its principal axes lie along x and y. `smooth` is the same without noise, if it has any: the
// height is chosen there. `from_file` is the rotation from the axes of the file to its axes. Errors: cancelled;
// unusable_scan if less than a twentieth of the height would be left. The error names a trim and, if there is one, an up
// axis that leave more; both were tried with `can_cut`.
Result<Trim> choose_trim(const TriangleMesh& closed, const std::optional<TriangleMesh>& smooth,
                         const ScanSettings& settings, const ScanFindings& findings,
                         const Eigen::Matrix3d& from_file, const std::string& file_name,
                         const CanCut& can_cut, const ScanProgress& progress);

// The share of the height that an automatic trim would keep of the same scan if it stood by other settings and another up
// axis. Errors: cancelled; unusable_scan as CoveredSpace.
Result<double> share_kept(const TriangleMesh& closed, const std::shared_ptr<const RayCaster>& caster,
                          const ScanSettings& settings, UpAxis up, const Eigen::Matrix3d& from_file,
                          const ScanProgress& progress);

}  // namespace vacuform
