// Calibration: the machine's few figures that matter, from one formed grid that was measured.
//
// Fitted are the height at which the frame stops, the opening of its window (width and height; a circle's diameter)
// and the stiffness of the sheet at the frame against its centre. The measured points are in whatever frame the
// measuring machine has: the rigid motion into the machine's is fitted along, unless the points are registered.
#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/studies/convergence.hpp"
#include "worker/studies/measured_grid.hpp"

namespace vacuform {

struct FittedParameter {
  std::string group, key;  // of the settings
  double value = 0;
  double standard_error =
      0;  // one sigma, of the noise that the residual shows; infinite where the data do not tell
  bool at_bound = false;  // the best value lies beyond what was searched
};

struct Calibration {
  std::vector<FittedParameter> parameters;
  Settings settings;  // with the fitted values
  DistanceStatistics before,
      after;                 // distances, mm, of all points: with the settings as given, and as fitted
  Eigen::Isometry3d motion;  // from the measured frame to the machine's
  int outliers = 0;          // points whose weight fell below a half
  int iterations = 0, formings = 0;
  bool converged = false;
};

struct CalibrationOptions {
  bool registered = false;  // the points are in the machine's frame
};

// Least squares by Levenberg and Marquardt's method with derivatives by differences, first on a grid of twice the
// spacing and then on the settings' own; weights of Huber ("Robust estimation of a location parameter", 1964), so
// that a few wild points do not count. Searched are a drape height from 0 to just under the mold's top, openings
// within a tenth of the given, edge stiffness from 0.2 to 5. Takes some thirty formings. Deterministic.
// Errors: those of form(); unusable_surface when fewer than ten points lie on the sheet; cancelled.
Result<Calibration> calibrate(const Prepared& prepared, const Settings& settings,
                              const std::vector<MeasuredPoint3>& points, const CalibrationOptions& options,
                              const Context& context);

// A machine profile: `given` (settings as they were written, without defaults) with the fitted values, and under
// "calibration" the figures, which are no settings and are skipped where the file is read as such. Of `given`, the
// groups "machine" and "forming" alone.
nlohmann::ordered_json profile_json(const Calibration& calibration, const nlohmann::json& given);

}  // namespace vacuform
