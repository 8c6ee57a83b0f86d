// Traces that are printed wider where the sheet stretches more, so that each millimetre has the same resistance.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "worker/conductors/gaps.hpp"
#include "worker/conductors/trace.hpp"

namespace vacuform {

// Resistance over that of an ink that only changes its shape, by rows of stretch and ratio (circuit.ink_stretch): between the
// rows, and beyond them that of the nearest; 1 without rows.
double ink_ratio(const std::vector<std::array<double, 2>>& rows, double stretch);

// Of a loop, at equal steps of about half a millimetre: the resistance of a millimetre of its formed trace over that of a
// millimetre as printed and equally wide, averaged over 6 mm. It is the ratio of areas times ink_ratio().
std::vector<double> trace_loads(const Trace& trace, const std::vector<std::array<double, 2>>& ink_stretch);

struct WidenedTrace {
  static constexpr double most = 3;
  double widest = 1;         // over the drawn width
  double mean = 1;           // the same, geometric mean along the trace
  double resistance = 1;     // of the trace, over that of an even one of the mean width
  std::vector<Shape> added;  // ink beside the trace, in black
};

// As wide as the loads ask for against `least`, at most WidenedTrace::most. Nothing is added in the `kept` intervals.
// Deterministic.
WidenedTrace widened(const Trace& trace, const std::vector<double>& loads, double least,
                     const std::vector<Interval>& kept);

}  // namespace vacuform
