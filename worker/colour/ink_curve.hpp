// How much ink a printer lays: what the stretched plastic still shows of a printed coverage.
//
// Colours are treated as coverages of three ideal inks: cyan, magenta and yellow cover 1 - red, 1 - green and 1 - blue of
// linear light. A coverage of 1 absorbs its light completely (Murray-Davies with an ideal solid). Stretching spreads the
// ink over more area. The coverage that plastic shows after its area grew by the ratio a is
//   shown = min(1, ink / a),  ink = curve(printed).
// The linear curve has ink = printed. Inks are independent: the unwanted absorption of real inks is not modelled.
#pragma once

#include <array>
#include <vector>

#include "api/settings.hpp"

namespace vacuform {

inline constexpr std::array<const char*, 3> ink_names{"cyan", "magenta", "yellow"};

// Colours as they are printed, or as the stretched plastic shows them.
enum class InkState { printed, stretched };

// One curve for each ink, straight between its points. Never falls.
class InkCurve {
 public:
  // Rows [printed, cyan, magenta, yellow] as settings_from_json() accepts them; none: linear.
  explicit InkCurve(const InkCurveRows& rows = {});

  float most(std::size_t ink) const { return linear_ ? 1 : ink_[ink].back(); }  // of full coverage
  float ink(std::size_t ink, float printed) const;                              // printed in [0, 1]
  // The least printed coverage that gives this much ink; 1 if none does.
  float printed(std::size_t ink, float amount) const;

 private:
  bool linear_;
  std::vector<float> printed_;
  std::array<std::vector<float>, 3> ink_;
};

}  // namespace vacuform
