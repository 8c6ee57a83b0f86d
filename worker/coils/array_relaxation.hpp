// Where the loops of an array may lie: circles of one size that push and pull each other along a surface as loops couple.
// Says in milliseconds which arrangements are worth being laid and decoupled exactly (decoupling.hpp).
#pragma once

#include <vector>

#include "worker/placement/spacing.hpp"

namespace vacuform {

// The coupling of two printed circles of one radius on a sphere, by Neumann's integral at the nodes of a table.
class CircleCouplings {
 public:
  CircleCouplings();
  struct Coupling {
    double k = 0, per_ratio = 0;  // and its change with the ratio
  };
  // `ratio`: distance of the centres over the diameter; `tilt`: angle of their normals, radians. Loops farther apart than
  // the table couple with nothing.
  Coupling at(double ratio, double tilt, double radius_mm, double trace_mm) const;

 private:
  std::vector<double> m_;  // mutual inductance of circles of radius 1 mm, nH
};

// What arrangements compete by.
struct Arrangement {
  std::vector<Centre> centres;
  double radius_mm = 0;
  double overlapping = 0, apart = 0,
         rms = 0;         // the largest |k| of loops that overlap, of those that do not; of all pairs
  int overlaps = 0;       // pairs that overlap
  double outside_mm = 0;  // how far the worst one reaches beyond the chart's border
  // 1 or less: overlapping loops below .0125, others below .031, rms below .009 and all on the head. Decoupling with sizes
  // that may change (decoupling.hpp) leaves about three quarters of these.
  double score() const;
};

// Of those that do about as well as the best, the one with the most overlaps: an array without gaps.
const Arrangement& best_of(const std::vector<Arrangement>& arrangements);

// A half of the chart by y, or all of it.
struct Half {
  double middle_y = 0;
  int side = 0;  // 1: above, -1: below, 0: all
  double outside_mm(const Eigen::Vector3d& place) const { return side * (middle_y - place.y()); }
};

// What does not change while circles move: samples of the chart's normals, and its border.
class Relaxation {
 public:
  Relaxation(const ChartedSurface& charted, const Half& half);  // centres stay on the half
  // Moves the centres, by the Levenberg-Marquardt method, until their circles couple as little as they can near where
  // they begin. Deterministic.
  Arrangement relaxed(std::vector<Centre> centres, double radius_mm, double trace_mm) const;

 private:
  struct Sample {
    Eigen::Vector3d place, normal;  // the normal as long as the area
  };
  struct State;
  struct Normal {
    Eigen::MatrixXd A;
    Eigen::VectorXd b;
  };
  State state(std::vector<Centre> centres, double radius_mm, double trace_mm) const;
  double cost(const State& state) const;
  Normal linearised(const State& state) const;
  State moved(const State& from, const Eigen::VectorXd& step) const;
  static Arrangement arrangement(State state);

  const ChartedSurface* charted_;
  Half half_;
  CircleCouplings couplings_;
  std::vector<Sample> samples_;  // by x
  std::vector<Eigen::Vector3d> border_;
};

}  // namespace vacuform
