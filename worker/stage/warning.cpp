#include "worker/stage/warning.hpp"

namespace vacuform {

std::string Warning::what_to_do() const {
  std::string advice = fix.empty() ? std::string(warning_kind(code).fix) : fix;
  if (proposals.empty()) return advice;
  if (advice.ends_with('.')) advice.pop_back();
  return advice_with(advice, proposals) + ".";
}

}  // namespace vacuform
