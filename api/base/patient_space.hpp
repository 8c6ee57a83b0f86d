// The axes of the patient that a file can name in its head or in a comment, as 3D Slicer writes it: "SPACE=LPS" and
// "SPACE=RAS". x, y and z point to the patient's left, back and head, or to the right, front and head.
#pragma once

#include <algorithm>
#include <string_view>

#include "api/base/text.hpp"

namespace vacuform {

enum class PatientSpace { unknown, lps, ras };

constexpr std::string_view name(PatientSpace space) {
  return space == PatientSpace::lps ? "LPS" : space == PatientSpace::ras ? "RAS" : "";
}

// The first place of a text that names a space, in any case: "SPACE=LPS".
struct NamedSpace {
  PatientSpace space = PatientSpace::unknown;
  std::size_t begin = 0, size = 0;
};
inline NamedSpace find_space(std::string_view text) {
  constexpr std::string_view key = "space=";
  const auto letter = [](char c) { return lower(c) >= 'a' && lower(c) <= 'z'; };
  for (std::size_t at = 0; at + key.size() + 3 <= text.size(); ++at) {
    if (!equal_ignoring_case(text.substr(at, key.size()), key)) continue;
    const std::size_t end = at + key.size() + 3;
    if ((at > 0 && letter(text[at - 1])) || (end < text.size() && letter(text[end]))) continue;
    const std::string_view value = text.substr(at + key.size(), 3);
    for (const PatientSpace space : {PatientSpace::lps, PatientSpace::ras})
      if (equal_ignoring_case(value, name(space))) return {space, at, key.size() + 3};
  }
  return {};
}

}  // namespace vacuform
