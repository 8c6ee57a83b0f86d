// How the formed places of measured points depend on a few parameters, by regression over a designed set of formings.
//
// A formed sheet depends on its grid: where the vertices lie, and when each of them touches the mold. From one forming
// to the next this moves the points erratically by hundredths of a millimetre, as much as a millimetre of window does,
// so a difference of two neighbouring formings is not a derivative. A central composite design (Box and Wilson, "On the
// experimental attainment of optimum conditions", J. R. Stat. Soc. B 13, 1951) takes wide steps, always in pairs +u and
// -u on the same grid, and another grid for each pair. The odd part of the pairs gives the slopes, free of the grid's
// error. The even part gives the level and the curvature, averaged over the grids (with weights, since the scatter
// grows with the square of the spacing), and the trend with that square, which is extrapolated to a spacing of 0. The
// scatter about both fits shows the simulation's own error.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vacuform {

struct DesignPoint {
  Eigen::VectorXd u;   // parameters, in units of the design's half width; each from -1 to 1
  double spacing = 1;  // of the grid, over the nominal one
};

// For 3 or 4 parameters: a pair at +-1 on each axis and four pairs at opposite corners of the cube of half side 0.7
// (for 4 parameters the half fraction in which no product of two parameters looks like a third); the members of a pair
// follow each other. Then five points at the centre. Spacings from 1.55 to 2.1 for the pairs, from 0.8 to 1.35 for the
// centres.
std::vector<DesignPoint> central_composite(int parameters);

class ResponseSurface {
 public:
  // `outputs`: one row a design point, in its order; one column a coordinate, mm.
  ResponseSurface(const std::vector<DesignPoint>& design, const Eigen::MatrixXd& outputs);

  // The outputs at u on a grid whose spacing tends to 0.
  Eigen::VectorXd value(const Eigen::VectorXd& u) const;
  // Their derivatives by u, one column a parameter: there, and the mean over the design.
  Eigen::MatrixXd slopes(const Eigen::VectorXd& u) const;
  const Eigen::MatrixXd& mean_slopes() const { return linear_; }

  // Independent errors of value(), one a column, one standard deviation each: their outer products sum to its
  // covariance. From the scatter about the fits, and from the uncertainty of the grid's order of convergence.
  const Eigen::MatrixXd& errors() const { return errors_; }
  // The variance of the slopes by chance, for an output of unit scatter; and the scatter of each output, mm2.
  const Eigen::MatrixXd& slope_covariance() const { return slope_covariance_; }
  const Eigen::VectorXd& slope_scatter() const { return slope_scatter_; }
  double freedom() const { return freedom_; }  // degrees of freedom behind errors()

 private:
  Eigen::VectorXd level_;
  Eigen::MatrixXd linear_, square_, errors_, slope_covariance_;
  Eigen::VectorXd slope_scatter_;
  double freedom_ = 0;
};

}  // namespace vacuform
