// How far forming stretches the printed lines, compared with the limit of their ink.
#pragma once

#include <string>
#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// Where the lines of one element are stretched beyond the ink's limit.
struct StretchedTrace {
  std::string id;                        // of the element; empty: of what is in no element
  double worst_stretch = 1;              // formed length / flat length of the worst millimetre
  Eigen::Vector3d worst_place{0, 0, 0};  // on the inked surface, mm
  double length_mm = 0,
         stretched_mm = 0;           // formed length of its centre lines, and of what is beyond the limit
  std::vector<Warning::Mark> marks;  // one for every connected part beyond the limit, worst first
};

class MeasuredSheet;

struct TraceFigures {
  double limit = 0;                        // coils.stretch_limit: 0.2 is 20 % longer
  int traces = 0;                          // elements with centre lines on the sheet
  double worst_stretch = 1;                // of all
  double length_mm = 0, stretched_mm = 0;  // of all
  std::vector<StretchedTrace> stretched;   // beyond the limit, worst first
  std::vector<Warning> warnings;           // "trace-stretched"
};

// Measures the print's centre lines a millimetre of the flat sheet at a time. Deterministic.
TraceFigures measure_traces(const MeasuredSheet& sheet, const VectorPrint& print, double stretch_limit);

}  // namespace vacuform
