// What the heaters on one side of the sheet radiate onto each place of it: exact view factors, and where reflector walls
// or the lip of the clamp frame stand in the way, rays that correct them.
//
// Assumptions: heaters are flat, parallel to the sheet and radiate diffusely towards it; reflectors are mirrors on their
// inner side (polished aluminium) and as cold as the surroundings; the lip is black and as cold. What of the half
// space no heater fills radiates as the surroundings do, so a place receives
// sigma (ambient temperature)^4 + above_surroundings().
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "api/settings.hpp"

namespace vacuform {

inline constexpr double stefan_boltzmann = 5.670374419e-8;  // W/(m2 K4), CODATA 2018
inline constexpr double absolute_zero = -273.15;            // degrees Celsius

class Irradiance {
 public:
  enum class Side { above, below };

  // Copies what it needs.
  Irradiance(const MachineSettings& machine, const HeatSettings& heat, Side side);
  ~Irradiance();
  Irradiance(Irradiance&&) noexcept;

  // W/m2 onto the place (sheet coordinates, mm, inside the window) more than from surroundings alone. Thread safe and
  // deterministic: the same rays for every place, symmetric under the symmetries of a square.
  double above_surroundings(const Eigen::Vector2d& place) const;

 private:
  // A heater as its side of the sheet sees it.
  struct Panel {
    double x0, x1, y0, y1, height;  // mm
    double radiosity;               // W/m2 above that of the surroundings
  };
  struct Walls;

  // The panel that a ray going up meets first, not above the height `limit`.
  const Panel* panel_met(const Eigen::Vector3d& from, const Eigen::Vector3d& way, double limit) const;
  double follow(Eigen::Vector3d from, Eigen::Vector3d way) const;
  double by_rays(const Eigen::Vector2d& place, double exact_without) const;

  std::vector<Panel> panels_;     // nearest first
  std::unique_ptr<Walls> walls_;  // none where nothing stands around
};

}  // namespace vacuform
