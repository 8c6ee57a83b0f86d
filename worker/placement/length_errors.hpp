// How long lines come out on the formed part, against the drawing: the check that no drawing passes in silence.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/placement/placement.hpp"

namespace vacuform {

// A line, or a part of it between places off the chart, that elements tie: its points as drawn, and where they lie.
struct TiedPoints {
  std::size_t element, shape, curve;         // Drawing::elements, Element::shapes, Shape::curves
  std::vector<Eigen::Vector2d> drawn, rest;  // parallel: pattern and sheet coordinates, mm
};

struct LengthErrors {
  // Of pieces of lines of at most 10 mm, or of both directions on squares of 5 mm: formed length over drawn length, less
  // 1, with its sign; what the drawing is scaled or a coil is resized by is not an error.
  struct Piece {
    double error = 0;
    double angle_deg = 0;  // that a right angle may be off there, the mean
    double drawn_mm = 0;
    int element = -1;                         // of the drawing; -1: of none
    std::vector<Eigen::Vector2d> drawn = {};  // pattern coordinates, mm
    Eigen::Vector3d place{0, 0, 0};           // on the inked surface, mm
  };
  std::vector<Piece> pieces;
  double mean = 0, p95 = 0, worst = 0;  // of |error| by length; 0 without pieces
  double worst_angle_deg = 0;
};

// Along the outlines and lines of `drawing`, or, without one, over the ink of `pattern` as it lies on the charts. `tied`
// says where lines lie that elements tie (VectorPrint::tied). `scale` is pattern.scale. What lies off its patch is left
// out. Deterministic; O(length of the lines).
LengthErrors length_errors(const Drawing* drawing, const Pattern& pattern, const Placement& placement,
                           const std::vector<TiedPoints>& tied, double scale);

// "length-off" above the limit and "length-far-off" above 10 %, with the places; nothing if all are below.
std::optional<Warning> length_warning(const LengthErrors& errors, const Drawing* drawing, double limit);

}  // namespace vacuform
