// The resistance that a conducting body gives to loops near it, and so their noise, quasi-static and exact for a sphere and
// a half space. Lengths in mm, conductivities in S/m, results in ohm.
//
// Quasi-static: valid while the body is small against the wavelength in it (0.6, 0.3 and 0.14 m at 1.5, 3 and 7 T) and the
// skin depth (89, 63 and 41 mm at 0.5 S/m). At 7 T the figures are no more than an order of magnitude.
#pragma once

namespace vacuform {

// A circle on a sphere about the centre of the body.
struct LoopOnSphere {
  double distance_mm = 0;  // of its points from the centre, above the body's radius
  double half_angle = 0;   // between the loop's axis and its points, radians, above 0
};

struct ConductingSphere {
  double radius_mm = 0;
  double conductivity = 0.6;  // of brain and muscle at 64 to 300 MHz, about .5 to .7
};

// R_ij of two loops whose axes lie `angle` apart, radians; with itself at angle 0 its own resistance:
//   sigma w^2 sum_l l / (l + 1) q_il q_jl 4 pi / (2 l + 1) R^(2 l + 3) / (2 l + 3) P_l(cos angle),
//   q_il = mu0 sin a_i P_l^1(cos a_i) / (2 l c_i^l),
// with R the radius of the body, c_i and a_i the distance and half angle of a loop. To a relative 1e-9. The ratio
// R_ij / sqrt(R_ii R_jj) is the correlation of the noise, which does not vanish where the inductive coupling does.
double noise_resistance(const ConductingSphere& body, const LoopOnSphere& a, const LoopOnSphere& b,
                        double angle, double frequency_mhz);

// Of a loop in parallel to the surface of a half space, so far above it:
//   pi / 4 sigma w^2 mu0^2 a^3 I(d / a), I(x) the integral of (J1(t) / t)^2 exp(-2 t x) over t > 0.
// A bound for a loop on a body that is not a sphere. To a relative 1e-5.
double half_space_resistance(double radius_mm, double above_mm, double conductivity, double frequency_mhz);

}  // namespace vacuform
