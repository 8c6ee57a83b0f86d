// The loops of an array as thin wires, for programs that take wires. Internal to worker/inspection. All need
// job.figures.electrical; `i` is an index into its loops.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Appends a character and a decimal.
void add_number(std::string& row, double value, int places, char before = ' ');

const std::string& loop_id(const Finished& job, std::size_t i);
std::vector<const LoopGap*> loop_gaps(const Finished& job, std::size_t i);  // the first is the port

constexpr double wire_radius_mm = 0.1;

struct LoopWire {
  std::vector<Eigen::Vector3d> points;  // closed, mm; begins at the port
  std::vector<std::size_t> gaps;        // the points that lie in them, in the order of loop_gaps()
};
// A polygon with pieces of at most 4.5 mm. It has corners wherever it crosses another loop: NEC-2 looks at the middles of
// wires, which are then far from each other. Where it crosses over another on the same face it is lifted off the part by
// .6 mm, because wires must not touch.
LoopWire loop_wire(const Finished& job, std::size_t i);

// array.nec: the tuned loops for NEC-2: a tag a loop, driven at the port of the first, at the frequency of the settings; the
// losses and the series capacitors are lumped.
std::string array_nec(const Finished& job);

// array-marie.msh: the same wires as a mesh of Gmsh 2.2 in metres, with a point element for each gap. The number of a node
// is that of the piece of wire that begins there. array-marie.json: the capacitors of the gaps in the same order.
std::string marie_mesh(const Finished& job);
std::string marie_circuit(const Finished& job);

}  // namespace vacuform
