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
  double drift_mm = 0;    // of its middle
  // Whether the loops leave no gaps, three of four pairs overlap of those that do in a hexagonal lattice, and all of them
  // lie on the head.
  bool is_whole() const;
  // 1 or less: overlapping loops below .0125, others below .031, rms below .009, all on the head, and about its middle.
  // Decoupling with sizes that may change (decoupling.hpp) leaves about three quarters of the couplings.
  double score() const;
};

// Of whole ones that do about as well as the best, the one with the most overlaps; without any, the best.
const Arrangement& best_of(const std::vector<Arrangement>& arrangements);

// A half of the chart by y, or all of it.
struct Half {
  double middle_y = 0;
  int side = 0;  // 1: above, -1: below, 0: all
  double outside_mm(const Eigen::Vector3d& place) const { return side * (middle_y - place.y()); }
};

// About what an array lies: the mean of its centres, and of their normals.
struct Middle {
  Eigen::Vector3d place{0, 0, 0}, up{0, 0, 0};
};

// What does not change while circles move: samples of the chart's normals, and its border.
class Relaxation {
 public:
  Relaxation(const ChartedSurface& charted, const Half& half);  // centres stay on the half
  Middle middle_of(const std::vector<Centre>& centres, double radius_mm) const;
  // Moves the centres, by the Levenberg-Marquardt method, until their circles couple as little as they can near where
  // they begin, and lie about `about`: they would slide to where the head is flat. Deterministic.
  Arrangement relaxed(std::vector<Centre> centres, double radius_mm, double trace_mm,
                      const Middle& about) const;

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
