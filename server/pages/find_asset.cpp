#include <algorithm>
#include <stdexcept>
#include <string>

#include "server/pages/assets.hpp"

namespace vacuform {

std::string_view asset(std::string_view name) {
  const auto all = assets();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Asset& file) { return file.name == name; });
  if (found == all.end()) throw std::logic_error("no such file is built in: " + std::string(name));
  return found->bytes;
}

}  // namespace vacuform
