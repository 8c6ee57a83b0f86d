// Heating and cooling of the sheet through its thickness: heat conduction between its two faces, radiation that is
// absorbed in depth, and on each face convection and re-radiation.
//
// The radiation of each side passes the face (absorptance) and fades as exp(-absorption * depth) (Beer-Lambert); what
// it does not leave in the sheet it takes out at the other face. A layer radiates to each side in the share in which it
// absorbs from there (Kirchhoff), so a sheet in surroundings of its own temperature keeps it. Radiation between
// layers is left to the conductivity, conduction along the sheet is left out: heat creeps 3 mm in a minute.
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
  double absorptance;      // of each face: what of the radiation passes it, 0 to 1
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

  // Advances the mean temperature of each layer, degrees Celsius from the top, by `seconds`, and gives the heat that
  // the slab took up, J/m2: the increase of its energy to round-off of the nonlinear solution. Thread safe.
  double advance(std::span<double> celsius, double seconds, const Exposure& top,
                 const Exposure& bottom) const;

  // Energy over that at 0 degrees Celsius, J/m2.
  double energy(std::span<const double> celsius) const;

  // Temperatures of the two faces, extrapolated linearly from the two layers next to each.
  static double top_celsius(std::span<const double> celsius);
  static double bottom_celsius(std::span<const double> celsius);

 private:
  // Solves u - step * f(u) = start for the temperatures u in place; f is the rate by all that acts, K/s. Gives the
  // power that comes in through the faces at u, W/m2.
  double solve_stage(std::span<double> u, std::span<const double> start, double step, const Exposure& top,
                     const Exposure& bottom) const;

  double capacity_;     // of a layer, J/(m2 K)
  double conductance_;  // between the middles of neighbours, W/(m2 K)
  double absorptance_;
  std::vector<double> from_top_, from_bottom_;  // share of what passes a face that each layer absorbs
};

}  // namespace vacuform
