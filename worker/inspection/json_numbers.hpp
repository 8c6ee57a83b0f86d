// Numbers as report.json contains them: rounded to their accuracy, null where the value is missing.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace vacuform {

// JSON cannot represent infinities and NaN.
inline nlohmann::ordered_json rounded(double value, int places = 4) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, places), r = std::round(value * scale) / scale;
  return std::isfinite(r) ? r + 0.0 : value;
}
inline nlohmann::ordered_json rounded(const std::optional<double>& value, int places = 4) {
  return value ? rounded(*value, places) : nlohmann::ordered_json(nullptr);
}

// For errors and residuals, where the magnitude matters and not the digits.
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
