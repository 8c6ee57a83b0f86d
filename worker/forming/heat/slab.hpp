// Heating and cooling of the sheet through its thickness: heat conduction between its two faces, radiation that is
// absorbed in depth, and on each face convection and re-radiation.
//
// The radiation of each side passes the face (absorptance) and decays as exp(-absorption * depth) (Beer-Lambert). The
// part that the sheet does not absorb leaves through the other face. A layer radiates to each side in the same share in
// which it absorbs from there (Kirchhoff), so a sheet in surroundings of its own temperature keeps it. The conductivity
// covers radiation between layers. Conduction along the sheet is neglected: heat spreads 3 mm in a minute.
//
// Finite volumes of equal thickness; in time the second-order, L-stable SDIRK method with gamma = 1 - sqrt(1/2)
// (Alexander, SIAM J. Numer. Anal. 14, 1977), the fourth powers by Newton's method.
#pragma once

#include <span>
#include <vector>

namespace vacuform {

struct SlabMaterial {
  double density_kg_m3;
  double heat_capacity_j_kgk;
  double conductivity_w_mk;
  double absorptance;      // of each face: the part of the radiation that passes it, 0 to 1
  double absorption_1_mm;  // in depth, may be infinite
};

// What one face is exposed to.
struct Exposure {
  double irradiance_w_m2;   // radiation onto it
  double convection_w_m2k;  // heat transfer to the air
  double air_celsius;
};

class Slab {
 public:
  // thickness_mm > 0, layers from 2 to 64.
  Slab(const SlabMaterial& material, double thickness_mm, int layers);

  int layers() const { return static_cast<int>(from_top_.size()); }

  // Advances the mean temperature of each layer, degrees Celsius from the top, by `seconds`. Returns the heat that the
  // slab absorbed, J/m2: the increase of its energy to round-off of the nonlinear solution. Thread safe.
  double advance(std::span<double> celsius, double seconds, const Exposure& top,
                 const Exposure& bottom) const;

  // Energy relative to 0 degrees Celsius, J/m2.
  double energy(std::span<const double> celsius) const;

  // Temperatures of the two faces, extrapolated linearly from the two layers next to each face.
  static double top_celsius(std::span<const double> celsius);
  static double bottom_celsius(std::span<const double> celsius);

 private:
  // Solves u - step * f(u) = start for the temperatures u in place; f is the rate due to all effects, K/s. Returns the
  // power that enters through the faces at u, W/m2.
  double solve_stage(std::span<double> u, std::span<const double> start, double step, const Exposure& top,
                     const Exposure& bottom) const;

  double capacity_;     // of a layer, J/(m2 K)
  double conductance_;  // between the centres of neighbours, W/(m2 K)
  double absorptance_;
  std::vector<double> from_top_, from_bottom_;  // absorbed share of what passes a face, per layer
};

}  // namespace vacuform
