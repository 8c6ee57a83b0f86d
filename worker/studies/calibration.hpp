// Calibration: the few machine settings that matter, from one formed grid that was measured.
//
// Fitted are the height at which the frame stops, the opening of its window (width and height; a circle's diameter) and
// the stiffness of the sheet at the frame against its centre. A measured point is compared with the place of the same
// point of the sheet on the face that carries the ink (pattern.inked_face). The measured points are in whatever frame
// the measuring machine has: the rigid motion into the machine's frame is fitted too, unless the points are registered.
//
// Points on a head hardly tell some of these apart, so each parameter has a prior: normal about the setting as given,
// with a standard deviation of 10 mm for the drape height and 5 mm for the window, and log-normal with 0.3 for the
// stiffness (a factor of 1.35). Where the points do not tell, the result stays at the prior.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/studies/convergence.hpp"
#include "worker/studies/measured_grid.hpp"

namespace vacuform {

// Errors are one standard deviation, in the parameter's unit; of the stiffness, whose error is a factor, the value
// times the error of its logarithm.
struct FittedParameter {
  std::string name;           // of the setting: "machine.drape_height_mm"
  double value = 0;           // with the prior
  double standard_error = 0;  // with the prior
  double points_error =
      0;  // by the points alone; infinite where they tell less than a hundredth of the prior
  double low95 = 0, high95 = 0;       // the interval that holds the truth in 95 of 100 cases, with the prior
  double prior = 0, prior_error = 0;  // of the logarithm where `logarithmic`
  bool logarithmic = false;
  bool at_bound = false;  // the best value lies at or beyond the end of what was searched
};

// A combination of parameters that the points know less than twice as well as the prior.
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

// Bayesian least squares (bayesian_fit.hpp) of a response surface (response_surface.hpp): 19 or 21 formings around the
// best values so far, again until the minimum lies well inside what they cover; first on grids twice as coarse. Five of
// the formings are on grids from 0.8 to 1.35 times the settings' spacing, the others on coarser ones. The errors are
// those of the points' noise, estimated from the residual, and of the simulation's grid, estimated from the scatter
// between the formings. Searched are a drape height from 0 to just under the mold's top, openings within a tenth of the
// given, edge stiffness from 0.2 to 5. Deterministic, the same bytes whatever the number of threads. Takes 40 to 170
// formings, most often 65.
// Errors: those of form(); bad_settings for a prior that is unknown or not positive; unusable_surface when a measured
// point lies off the sheet; cancelled.
Result<Calibration> calibrate(const Prepared& prepared, const Settings& settings,
                              const std::vector<MeasuredPoint3>& points, const CalibrationOptions& options,
                              const Context& context);

// A machine profile: `given` (settings as they were written, without defaults) with the fitted values, and under
// "calibration" the figures, which are no settings and are skipped where the file is read as such. Of `given`, the
// groups "machine" and "forming" alone.
nlohmann::ordered_json profile_json(const Calibration& calibration, const nlohmann::json& given);

// The same for people: a table of the values, the correlations, what the points do not tell, the residual.
std::string text_of(const Calibration& calibration);

}  // namespace vacuform
