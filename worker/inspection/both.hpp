// The two ways of printing a drawing, which inspection compares: as it is drawn, and pre-distorted.
#pragma once

#include <array>

namespace vacuform {

enum class Way { without, with };  // the pre-distortion
inline constexpr std::array<Way, 2> both_ways{Way::without, Way::with};

// One of each. A row of a table that has figures for both ways derives from it.
template <class T>
struct Both {
  T without, with;

  T& operator[](Way way) { return way == Way::with ? with : without; }
  const T& operator[](Way way) const { return way == Way::with ? with : without; }
};

}  // namespace vacuform
