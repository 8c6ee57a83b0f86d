// Indices that are kept as int, for the containers of the standard library.
#pragma once

#include <cstddef>

namespace vacuform {

inline std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace vacuform
