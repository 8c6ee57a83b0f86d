// Heaters, for tests.
#pragma once

#include <cmath>

#include "worker/forming/heat/irradiance.hpp"

namespace vacuform {

inline Heater heater(double x, double y, double width, double height, double z, double celsius) {
  Heater h;
  h.x_mm = x, h.y_mm = y, h.z_mm = z, h.width_mm = width, h.height_mm = height, h.celsius = celsius;
  return h;
}

// What a black face of that temperature radiates, W/m2.
inline double black(double celsius) { return stefan_boltzmann * std::pow(celsius + 273.15, 4); }

}  // namespace vacuform
