// The files that take an array from the print to the bench and into other programs. Internal to worker/inspection and
// worker/pipeline. All need job.figures.electrical.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Frequency, body and loops, as in report.json.
nlohmann::ordered_json electrical_json(const Finished& job);

// "capacitors-small": capacitors to solder below least_gap_pf (gaps.hpp), which stray capacitance detunes.
std::optional<Warning> small_capacitors(const Finished& job);

// coils.csv: a row for each gap, with the capacitor to solder and its place, and of a port its tail; fields by commas, as RFC 4180 has them.
std::string coils_csv(const Finished& job);

// array.json: the same with the matrices of coupling, of the currents that a current in the loop of the row drives in that of
// the column with preamplifiers, and of noise, and the loops in space.
std::string array_json(const Finished& job);

// array.ts: the scattering matrix of the tuned and matched array at its ports, Touchstone 2.0, 2.5 % about the frequency.
std::string array_touchstone(const Finished& job);

}  // namespace vacuform
