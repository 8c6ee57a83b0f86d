// The loops of a formed array as circuits: what a technician solders, and what the losses of each loop cost.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "api/settings.hpp"
#include "worker/coils/coupling_matrix.hpp"
#include "worker/electrical/body_noise.hpp"

namespace vacuform {

// A sphere of least squares through points (Kasa's linear fit).
struct FittedSphere {
  Eigen::Vector3d centre{0, 0, 0};  // mm
  double radius_mm = 0;
  double rms_mm = 0;  // of the points' distances from it
};
// Nothing for fewer than four points, or points of one plane.
std::optional<FittedSphere> fit_sphere(const std::vector<Eigen::Vector3d>& points);

// What the loops lie on: the sheet on the head, less its thickness and what is under it.
struct BodyBelow {
  FittedSphere sphere;
  double above_mm = 0;  // of the loops over it
};

struct LoopOnPart {
  std::vector<Eigen::Vector3d> line;  // closed, mm
  double inductance_nh = 0;
  // Of the trace: the integral of the ratio of formed to flat area over its width, along it, times what stretch makes of the
  // ink (circuit.ink_stretch). An ink that only changes its shape has so many times the resistance of a printed square.
  double squares = 0;
  int gaps = 1;             // that share the capacitance, at least 1
  double loss_tangent = 0;  // of the capacitors in series
};

struct LoopCircuit {
  double coil_ohm = 0;              // of its trace and its capacitors
  double body_ohm = 0;              // of the body as a sphere; 0: no body
  double most_body_ohm = 0;         // of a half space at the loop's distance: a bound
  double unloaded = 0, loaded = 0;  // qualities
  double noise_db = 0;              // what the coil's own loss adds to the noise of the body
  double matching_pf = 0;           // across the port; 0: the loop has more resistance than the port
  double series_pf = 0;             // of all other capacitors in series, then
  // In all, for each of its gaps, and of the E24 series.
  struct Capacitors {
    double mhz = 0, total_pf = 0, gap_pf = 0, standard_pf = 0, detuning = 0;
  };
  std::array<Capacitors, 4> capacitors;  // at 1.5, 3 and 7 T, and at circuit.frequency_mhz
};

struct ArrayCircuit {
  FittedSphere body;
  std::vector<LoopCircuit> loops;
  CouplingMatrix noise;  // correlation of the noise of every two loops, with their own losses
};

// At circuit.frequency_mhz, if not said otherwise. Deterministic; the correlations take O(n^2). The body is a sphere: correlations of neighbours on a head are good to some .05.
ArrayCircuit array_circuit(const std::vector<LoopOnPart>& loops, const BodyBelow& body,
                           const CircuitSettings& settings);

}  // namespace vacuform
