#include "worker/electrical/array_circuit.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "worker/electrical/tuning.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

// The loop as a circle: the area vector gives its axis and radius.
struct Circle {
  Vector3d centre{0, 0, 0};
  double radius_mm = 0;
};
Circle circle_of(const std::vector<Vector3d>& line) {
  Circle out;
  Vector3d area(0, 0, 0);
  for (const Vector3d& p : line) out.centre += p / static_cast<double>(line.size());
  for (std::size_t i = 0; i < line.size(); ++i)
    area += (line[i] - out.centre).cross(line[(i + 1) % line.size()] - out.centre) / 2;
  out.radius_mm = std::sqrt(area.norm() / M_PI);
  return out;
}

LoopCircuit::Capacitors capacitors(const LoopOnPart& loop, double mhz) {
  LoopCircuit::Capacitors out{mhz, tuning_pf(loop.inductance_nh, mhz), 0, 0, 0};
  out.gap_pf = out.total_pf * loop.gaps;
  const StandardValue value = standard_value(out.gap_pf);
  out.standard_pf = value.pf, out.detuning = value.detuning;
  return out;
}

}  // namespace

std::optional<FittedSphere> fit_sphere(const std::vector<Vector3d>& points) {
  if (points.size() < 4) return std::nullopt;
  Vector3d middle(0, 0, 0);
  for (const Vector3d& p : points) middle += p / static_cast<double>(points.size());
  // |p|^2 = 2 p.c + (r^2 - c^2), about the middle.
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Vector3d& p : points) {
    const Vector3d q = p - middle;
    const Eigen::Vector4d row(2 * q.x(), 2 * q.y(), 2 * q.z(), 1);
    normal += row * row.transpose();
    right += row * q.squaredNorm();
  }
  const Eigen::ColPivHouseholderQR<Eigen::Matrix4d> solver(normal);
  if (solver.rank() < 4) return std::nullopt;
  const Eigen::Vector4d x = solver.solve(right);
  FittedSphere out{middle + x.head<3>(), std::sqrt(x[3] + x.head<3>().squaredNorm()), 0};
  if (!(out.radius_mm > 0)) return std::nullopt;
  for (const Vector3d& p : points)
    out.rms_mm += std::pow((p - out.centre).norm() - out.radius_mm, 2) / static_cast<double>(points.size());
  out.rms_mm = std::sqrt(out.rms_mm);
  return out;
}

ArrayCircuit array_circuit(const std::vector<LoopOnPart>& loops, const BodyBelow& under,
                           const CircuitSettings& settings) {
  const FittedSphere& body = under.sphere;
  const double above_mm = under.above_mm;
  const double mhz = settings.frequency_mhz;
  const ConductingSphere sphere{body.radius_mm, settings.conductivity};
  ArrayCircuit out{body, std::vector<LoopCircuit>(loops.size()),
                   CouplingMatrix(static_cast<int>(loops.size()))};
  std::vector<LoopOnSphere> on_sphere;
  std::vector<Vector3d> axes;
  for (const LoopOnPart& loop : loops) {
    const Circle circle = circle_of(loop.line);
    const double distance = body.radius_mm + above_mm;
    on_sphere.push_back({distance, std::asin(std::min(1.0, circle.radius_mm / distance))});
    axes.push_back((circle.centre - body.centre).normalized());
    LoopCircuit& of = out.loops[on_sphere.size() - 1];
    of.coil_ohm = settings.ink_mohm / 1000 * loop.squares +
                  loop.loss_tangent * angular_frequency(mhz) * loop.inductance_nh * 1e-9;
    of.most_body_ohm = half_space_resistance(circle.radius_mm, above_mm, settings.conductivity, mhz);
    of.capacitors = {capacitors(loop, 1.5 * proton_mhz_per_tesla), capacitors(loop, 3 * proton_mhz_per_tesla),
                     capacitors(loop, 7 * proton_mhz_per_tesla), capacitors(loop, mhz)};
  }
  const int count = static_cast<int>(loops.size());
  CouplingMatrix& ohm = out.noise;
  in_parallel(0, count, [&](int first, int last) {
    for (int a = first; a < last; ++a)
      for (int b = a; b < count; ++b) {
        const double angle =
            a == b ? 0 : std::acos(std::clamp(axes[index(a)].dot(axes[index(b)]), -1.0, 1.0));
        ohm.set(a, b, noise_resistance(sphere, on_sphere[index(a)], on_sphere[index(b)], angle, mhz));
      }
  });
  for (int a = 0; a < count; ++a) {
    LoopCircuit& of = out.loops[index(a)];
    const LoopOnPart& loop = loops[index(a)];
    of.body_ohm = ohm(a, a);
    of.unloaded = quality(loop.inductance_nh, mhz, of.coil_ohm);
    of.loaded = quality(loop.inductance_nh, mhz, of.coil_ohm + of.body_ohm);
    of.noise_db = noise_figure_db(of.coil_ohm, of.body_ohm);
    const Match matched = match(loop.inductance_nh, of.coil_ohm + of.body_ohm, settings.port_ohm, mhz);
    of.matching_pf = matched.port_pf, of.series_pf = matched.series_pf;
  }
  for (int a = 0; a < count; ++a)
    for (int b = a; b < count; ++b) {
      const auto all = [&](int i) { return out.loops[index(i)].body_ohm + out.loops[index(i)].coil_ohm; };
      ohm.set(a, b, a == b ? 1 : ohm(a, b) / std::sqrt(all(a) * all(b)));
    }
  return out;
}

}  // namespace vacuform
