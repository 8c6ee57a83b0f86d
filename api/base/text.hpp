// Small operations on ASCII text. Bytes above 127 stay as they are.
#pragma once

#include <string>
#include <string_view>

namespace vacuform {

// Without the blanks, tabs, carriage returns and line feeds at both ends.
std::string_view trimmed(std::string_view text);

bool equal_ignoring_case(std::string_view a, std::string_view b);

std::string lower(std::string_view text);

}  // namespace vacuform
