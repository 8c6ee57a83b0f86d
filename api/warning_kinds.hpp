// What a warning means: the codes, for reports, pages and the reference.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace vacuform {

enum class Severity {
  note,     // nothing to do: what was chosen, or what cannot be better
  warning,  // look at the place before printing
  serious   // do not print before this is settled
};
constexpr std::string_view name(Severity severity) {
  constexpr std::array<std::string_view, 3> names{"note", "warning", "serious"};
  return names[static_cast<std::size_t>(severity)];
}

// One row for each code.
struct WarningKind {
  std::string_view code;  // stable, for machines: "undercut"
  Severity severity;
  std::string_view meaning;  // for people
  std::string_view fix;      // what to do, if a warning has no fix of its own
};
std::span<const WarningKind> warning_kinds();            // sorted by code
const WarningKind& warning_kind(std::string_view code);  // any other code is a bug, which ends the program

}  // namespace vacuform
