// Calibration: fits the few machine settings that matter to one measured formed grid.
//
// The fitted parameters are the height at which the frame stops, the opening of its window (width and height; diameter
// for a circle) and the stiffness of the sheet at the frame relative to its centre. A measured point is compared with
// the place of the same point of the sheet on the face that carries the ink (pattern.inked_face). The measured points
// are in the frame of the measuring machine: the rigid motion into the frame of the forming machine is fitted too,
// unless the points are registered.
//
// Points on a head hardly distinguish some of these, so each parameter has a prior: normal about the given setting,
// with a standard deviation of 10 mm for the drape height and 5 mm for the window, and log-normal with 0.3 for the
// stiffness (a factor of 1.35). Where the points contain no information, the result stays at the prior.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/studies/convergence.hpp"
#include "worker/studies/measured_grid.hpp"

namespace vacuform {

// Errors are one standard deviation, in the unit of the parameter; for the stiffness, whose error is a factor, they are
// the value times the error of its logarithm.
struct FittedParameter {
  std::string name;           // of the setting: "machine.drape_height_mm"
  double value = 0;           // with the prior
  double standard_error = 0;  // with the prior
  double points_error =
      0;  // by the points alone; infinite where they tell less than a hundredth of the prior
  double low95 = 0, high95 = 0;       // the interval that holds the truth in 95 of 100 cases, with the prior
  double prior = 0, prior_error = 0;  // of the logarithm where `logarithmic`
  bool logarithmic = false;
  bool at_bound = false;  // the best value lies at or beyond the end of the search range
};

// A combination of parameters whose error from the points is more than half of that of the prior.
struct Unresolved {
  std::vector<double> share;   // of each parameter, in prior standard deviations; the squares sum to 1
  double points_to_prior = 0;  // standard error by the points alone over that of the prior; may be infinite
  std::string text;            // one sentence
};

struct Calibration {
  std::vector<FittedParameter> parameters;
  Eigen::MatrixXd correlation;          // of the errors with the prior
  std::vector<Unresolved> unresolved;   // the least known first
  std::vector<std::string> trade_offs;  // one sentence for each pair whose errors correlate by more than 0.8
  Settings settings;                    // with the fitted values
  DistanceStatistics before,
      after;                  // distances, mm, of all points: with the settings as given, and as fitted
  double noise_mm = 0;        // standard deviation of a measured coordinate, by the residual
  double model_error_mm = 0;  // of a simulated coordinate: the grid's error, rms over the points
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  // from the measured frame to the machine's
  int outliers = 0;                                          // points whose weight fell below a half
  int rounds = 0, formings = 0;
  bool converged = false;
};

struct CalibrationOptions {
  bool registered = false;  // the points are in the machine's frame
  // Other standard deviations of the prior, by the name of the setting; of the stiffness that of its logarithm.
  std::map<std::string, double> prior_errors;
};

// Bayesian least squares (bayesian_fit.hpp) of a response surface (response_surface.hpp). Each round makes 19 or 21
// formings around the best values so far; rounds are repeated until the minimum lies well inside what they cover, first
// on grids twice as coarse. Five of the formings of a round are on grids from 0.8 to 1.35 times the settings' spacing,
// the others on coarser ones. The errors are those of the points' noise, estimated from the residual, and of the
// simulation's grid, estimated from the scatter between the formings. The search covers a drape height from 0 to just
// under the mold's top, openings within a tenth of the given ones, and an edge stiffness from 0.2 to 5. Deterministic,
// the same bytes whatever the number of threads. Takes at most 170 formings, most often 65. Errors: those of form();
// bad_settings for a prior that is unknown or not positive; unusable_surface when a measured point lies off the sheet;
// cancelled.
Result<Calibration> calibrate(const Prepared& prepared, const Settings& settings,
                              const std::vector<MeasuredPoint3>& points, const CalibrationOptions& options,
                              const Context& context);

// A machine profile: `given` (settings as written, without defaults) with the fitted values, and the figures under
// "calibration". The figures are not settings and are skipped when the file is read as settings. Only the groups
// "machine" and "forming" of `given` are included.
nlohmann::ordered_json profile_json(const Calibration& calibration, const nlohmann::json& given);

// The same for people: a table of the values, the correlations, the unresolved parameters, the residual.
std::string text_of(const Calibration& calibration);

}  // namespace vacuform
