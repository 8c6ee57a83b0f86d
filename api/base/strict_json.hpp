// JSON (RFC 8259) from people and programs, read strictly. An object that holds one name twice is refused: readers disagree
// about which value counts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

inline constexpr int deepest_json = 16;  // levels of objects and arrays

// Json is nlohmann::json or nlohmann::ordered_json. Errors: bad_usage (not one JSON value, a repeated name, more than
// `deepest` levels); `where` is empty, for the caller to fill in.
template <class Json>
Result<Json> strict_json(std::string_view text, int deepest = deepest_json);

}  // namespace vacuform
