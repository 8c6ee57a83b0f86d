// Numbers as they stand in report.json: rounded to what is known of them, null where there is none.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace vacuform {

// Infinities and NaN have no place in JSON.
inline nlohmann::ordered_json rounded(double value, int places = 4) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, places), r = std::round(value * scale) / scale;
  return std::isfinite(r) ? r + 0.0 : value;
}
inline nlohmann::ordered_json rounded(const std::optional<double>& value, int places = 4) {
  return value ? rounded(*value, places) : nlohmann::ordered_json(nullptr);
}

// For errors and residuals, whose size counts and not their digits.
inline nlohmann::ordered_json significant(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0.0;
  const double scale = std::pow(10.0, 2 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

template <class Vector>
nlohmann::ordered_json array(const Vector& v, int places) {
  auto out = nlohmann::ordered_json::array();
  for (int k = 0; k < v.size(); ++k) out.push_back(rounded(v[k], places));
  return out;
}

}  // namespace vacuform
