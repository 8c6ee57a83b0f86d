#include "worker/colour/ink_curve.hpp"

#include <algorithm>

namespace vacuform {

namespace {

// The least x at which the line through the points reaches y; xs ascend, ys never fall. Within their range.
float where_reached(const std::vector<float>& xs, const std::vector<float>& ys, float y) {
  const auto at = std::lower_bound(ys.begin(), ys.end(), y);
  if (at == ys.begin()) return xs.front();
  if (at == ys.end()) return xs.back();
  const auto i = static_cast<std::size_t>(at - ys.begin());
  return xs[i - 1] + (xs[i] - xs[i - 1]) * (y - ys[i - 1]) / (ys[i] - ys[i - 1]);
}

}  // namespace

InkCurve::InkCurve(const InkCurveRows& rows) : linear_(rows.empty()) {
  for (const auto& row : rows) {
    printed_.push_back(static_cast<float>(row[0]));
    for (std::size_t k = 0; k < ink_.size(); ++k) ink_[k].push_back(static_cast<float>(row[k + 1]));
  }
}

float InkCurve::ink(std::size_t ink, float printed) const {
  return linear_ ? std::clamp(printed, 0.0f, 1.0f) : where_reached(ink_[ink], printed_, printed);
}

float InkCurve::printed(std::size_t ink, float amount) const {
  return linear_ ? std::clamp(amount, 0.0f, 1.0f) : where_reached(printed_, ink_[ink], amount);
}

}  // namespace vacuform
