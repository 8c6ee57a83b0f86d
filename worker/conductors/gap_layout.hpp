// The gaps of an array: their places, pads and capacitors, and the plates of those that are printed.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "worker/conductors/plates.hpp"
#include "worker/electrical/array_circuit.hpp"

namespace vacuform {

// Of a loop, in the order along it from its port.
struct LoopGap {
  int coil = 0;    // index into Drawing::elements
  Interval along;  // of its loop in the drawing (loop_path.hpp)
  bool port = false;
  bool drawn = false;               // in the drawing, and not made here
  std::optional<Plate> plate = {};  // of a printed capacitor, on the other face
  int number = 0;                   // from 1, in the tables and on the print
  Eigen::Vector3d place{0, 0, 0};   // of its middle on the inked surface of the coil's face, mm
  Eigen::Vector2d rest{0, 0};       // the same on the flat sheet, mm
  Eigen::Vector2d inwards{1, 0};    // there, a unit vector across the trace
};

// Of a capacitor's footprint, mm on the part: between the pads, along the trace, and across it. Of printed ones: at the port.
struct Pads {
  double gap, length, width;
};
Pads pads_of(const CoilSettings& settings);

// Capacitors are printed.
bool prints_plates(const CoilSettings& settings);

// A loop as it lies on its face.
struct LaidLoop {
  int element = 0;                // index into Drawing::elements
  std::unique_ptr<Trace> trace;   // never null
  std::unique_ptr<Trace> far;     // the same on the other face; null if no plates are printed
  Eigen::Vector2d centre{0, 0};   // on the flat sheet, mm
  std::vector<Interval> drawn;    // gaps of the drawing
  std::vector<Interval> covered;  // parts with bridges and patches: no gap lies there
};

struct GapLayout {
  std::vector<LoopGap> gaps;      // by loop
  std::vector<Warning> warnings;  // "gaps-left-out", "plates-small"
};

// Gaps as settings.coils asks for loops without drawn ones. `border`: of the chart, in space, towards which the ports lie.
// `body` loads the loops. Deterministic.
GapLayout lay_gaps(const std::vector<LaidLoop>& loops, const std::vector<Eigen::Vector3d>& border,
                   const std::optional<BodyBelow>& body, const Settings& settings);

}  // namespace vacuform
