// Where a loop is interrupted for its capacitors and its port.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/conductors/islands.hpp"
#include "worker/conductors/loop_path.hpp"
#include "worker/pattern/area.hpp"

namespace vacuform {

// Lengths along the loop in the drawing, mm; from < to, and `to` may lie beyond the loop's length.
struct Interval {
  double from = 0, to = 0;
  double middle() const { return (from + to) / 2; }
  double length() const { return to - from; }
};

// The gaps that a drawing leaves in the trace of a loop, by their beginnings: where the middle of the trace has no ink.
// `ink` is all ink of the element. Shorter ones than 0.05 mm do not count.
std::vector<Interval> drawn_gaps(const LoopPath& path, const Area& ink);

// The parts of the trace whose middle has ink of `ink`, in the same way; none if all of it has.
std::vector<Interval> inked_parts(const LoopPath& path, const Islands& ink);

// How many gaps a loop needs: as few as leave parts of at most a tenth of a wavelength in air, and capacitors of at least
// least_gap_pf, for the inductance of a circular strip of that length and width. At most 16, at least 2: the port and
// one to tune.
int gaps_for_frequency(double length_mm, double width_mm, double frequency_mhz);
inline constexpr double least_gap_pf = 2;

// The room of a gap to each side of its middle, mm in the drawing. A port with a tail needs more.
struct GapRoom {
  double half = 0, of_port = 0;
};

// `count` places for gaps: equally spaced, the first at `port` as nearly as possible. None meets the blocked intervals: where
// equal spaces do not allow it, a gap is moved by as little as possible. A port that has no place with its own room takes that
// of the others. The result begins with the port and goes round. Fewer than `count`: the rest has no place.
// Deterministic; O(n) in the blocked intervals for each of 120 rotations and each gap.
std::vector<double> places_for_gaps(double length, int count, const GapRoom& room, double port,
                                    const std::vector<Interval>& blocked);

}  // namespace vacuform
