#include "api/base/error.hpp"

#include "api/base/utf8.hpp"

namespace vacuform {

std::string Error::text() const {
  std::string line = what;
  if (!where.empty()) line += " (" + where + ")";
  if (!fix.empty()) line += "; " + fix;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  return printable(line);
}

}  // namespace vacuform
