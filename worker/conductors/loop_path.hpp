// The loop of a coil by the length along it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Lengths are those of the drawing, mm, from the first point of the line on. A length beyond the end goes round again, and
// so does one below 0.
class LoopPath {
 public:
  explicit LoopPath(const DrawnLoop& loop);

  double length() const { return along_.back(); }
  double width() const { return width_; }
  // Its points with the length up to each; the first is repeated as the last.
  const std::vector<Eigen::Vector2d>& points() const { return points_; }
  const std::vector<double>& along() const { return along_; }

  Eigen::Vector2d at(double along) const;
  // From one length to a larger one, at most once round: an open line.
  Curve part(double from, double to) const;
  double round(double along) const;  // the same place in [0, length)

 private:
  std::size_t piece(double along) const;  // that holds a length in [0, length)
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> along_;
  double width_;
};

// How far it is from one length to another the shorter way round, at least 0.
double apart_on_loop(double a, double b, double length);

// Straight pieces through the points, as a curve.
Curve straight_curve(const std::vector<Eigen::Vector2d>& points);

}  // namespace vacuform
