// The files that take an array from the print to the bench and into other programs. Internal to worker/inspection. All need
// job.figures.electrical.
#pragma once

#include <string>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// coils.csv: a row for each gap, with the capacitor to solder and its place; fields by commas, as RFC 4180 has them.
std::string coils_csv(const Finished& job);

// array.json: all figures of the circuits, the matrices of coupling and of noise, the loops in space.
std::string array_json(const Finished& job);

// array.nec: the tuned loops as wires, for NEC-2: a tag a loop, driven at the port of the first, at the frequency of the
// settings. Wires of loops that cross on one face meet between their ends, where NEC-2 takes them as apart.
std::string array_nec(const Finished& job);

// array.ts: the scattering matrix of the tuned and matched array at its ports, Touchstone 2.0, 2.5 % about the frequency.
std::string array_touchstone(const Finished& job);

}  // namespace vacuform
