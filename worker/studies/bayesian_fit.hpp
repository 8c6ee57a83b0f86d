// Bayesian least squares of a response surface to measured points.
//
// The measured places, moved rigidly, are y = f(t) + noise + error. The noise has the same variance everywhere,
// estimated from the residual. The error is that of the simulation (ResponseSurface::errors): all points share it, so
// it does not average out over them. The points then determine the parameters t through the projection J't with the
// covariance M = s2 A + B, where A = J' W J, B is the covariance of the error in the same projection, and W are Huber's
// weights ("Robust estimation of a location parameter", Ann. Math. Stat. 35, 1964). Their information is A M^-1 A; the
// information of the prior is added to it (Tarantola, "Inverse Problem Theory", 2005, chapter 3). The six parameters of
// the rigid motion are projected out of J, which is the same as marginalising them with no prior. The random errors of
// the slopes increase A on average; that part is subtracted, because it would count as information that does not exist.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/studies/response_surface.hpp"

namespace vacuform {

struct FitProblem {
  std::vector<Eigen::Vector3d> measured;  // mm
  bool registered = false;                // measured in the frame of the machine: no motion is fitted
  Eigen::VectorXd centre, half_width;     // of the surface's design: u = (t - centre) / half_width
  Eigen::VectorXd low, high;              // of t, which also stays within 1.25 half widths of the centre
  Eigen::VectorXd prior_mean, prior_sd;
};

struct BayesianFit {
  Eigen::VectorXd t;
  Eigen::MatrixXd information;  // of the points alone, about t; singular where they contain no information
  Eigen::MatrixXd covariance;   // with the prior
  Eigen::VectorXd freedom;  // degrees of freedom behind each variance; hundreds unless the error dominates
  double noise_mm = 0;      // one standard deviation of a measured coordinate
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  // from the measured frame to that of the machine
  std::vector<double> weights;                               // of the points: 1, less for outliers
  bool converged = false;
};

// Gauss-Newton method; the weights and the motion are recomputed at each step. Deterministic.
BayesianFit bayesian_fit(const FitProblem& problem, const ResponseSurface& surface);

// The motion and the weights that fit the measured points to `places` (x, y, z each), and the distance of each point,
// mm.
struct Laid {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  std::vector<double> weights, lengths;
};
Laid lay_points(const FitProblem& problem, const Eigen::VectorXd& places);

// Half width of the 95 % interval, in standard deviations, by Student's t (Abramowitz and Stegun, 26.7.5; better than 1
// % from 4 degrees of freedom).
double interval_95(double freedom);

}  // namespace vacuform
