// Which way is up, and how far a scan is tilted: what its shape says, ranked, with a confidence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/stage/warning.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A plane in which a body was cut off: a flat side, or the plane through the border of an opening.
struct Cut {
  Eigen::Vector3d normal;  // of the missing face, outwards, one unit long
  double area;             // of the missing face, as a share of the area of the skin
  bool open;               // an opening; otherwise a flat side
  double rim;  // how far the surface along the border of an opening looks out of it: the mean cosine
};

// The flat sides of a body at any angle with at least a fiftieth of its area (the body lies behind their plane, to 0.4 %
// of its diagonal), and its openings with at least as much; the largest first. `noise_mm` of the surface widens the plane to four times that.
// O(n log n).
std::vector<Cut> find_cuts(const TriangleMesh& skin, double noise_mm = 0);

struct UpCandidate {
  UpAxis axis;
  double confidence;  // 0 to 1; those of all six axes add up to 1
  std::string why;    // one clause for people
};

struct UpGuess {
  std::vector<UpCandidate> candidates;  // six, the most likely first
  std::vector<Cut> cuts;                // in the axes of the skin
  std::optional<Eigen::Vector3d> side;  // normal of the median plane of a body without a foot, if it has one
  double evidence =
      0;  // the confidence of best() without the habit of exporters; 0 without a cut on its other side
  const UpCandidate& best() const { return candidates.front(); }
  bool conclusive() const;  // best() is certain enough to be used without a question
};

// Ranks the six axes of a scan by what its shape says of its foot, as a sum of log-likelihoods:
// - a cut whose missing face looks down: the neck of a head is open or cut flat, its crown is round and closed; of
//   several flat sides the widest;
// - how much can be formed: the height of the mold that a trim leaves, times the share of it that is a dome (a skull, not
//   a face). Only undercuts larger than those of ears, dents and grain count;
// - without a cut that looks down: the end there (a crown is broader than a chin), and whether a plane through the axis
//   is a plane of symmetry, as far as the body has any;
// - habit: exporters write +z or +y.
// Small separate pieces and grain are left out. A broken skin is judged by a wrap around it, and never certain. The
// confidences were fitted to made-up heads of known pose (tests/integration/generated_scans.py --poses). Takes about
// 0.1 s for 27,000 triangles, and a few tenths more without a cut that looks down. Error: cancelled.
Result<UpGuess> guess_up(const TriangleMesh& skin, const ScanProgress& progress);

// A tilt of a scan, and the settings that straighten it.
struct Tilt {
  enum class Of { opening, flat_side, median_plane };
  static constexpr double foot_limit_deg = 20;  // necks of straight heads are cut less obliquely
  static constexpr double side_limit_deg = 10;  // their median planes are less oblique
  double angle_deg;            // of the foot from the platform, or of the median plane from the vertical
  double roll_deg, pitch_deg;  // rounded to 0.1
  Of of;
  double limit_deg() const { return of == Of::median_plane ? side_limit_deg : foot_limit_deg; }
};

// The warning "up-guessed": the axis that is used, its confidence, and the settings of the other likely ones. `told`: the
// format says that the axis is up, and the shape contradicts.
Warning up_warning(const UpGuess& guess, UpAxis used, bool told);

// The tilt of the largest cut that looks down by at least 30 degrees; without one, that of the median plane, which does
// not show whether the head nods. Nothing if it is within the limit. `stood`: from the axes of the guess to the upright
// scan, before roll and pitch.
std::optional<Tilt> find_tilt(const UpGuess& guess, const Eigen::Matrix3d& stood);

}  // namespace vacuform
