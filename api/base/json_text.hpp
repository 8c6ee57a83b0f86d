// Texts in JSON that another program wrote.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace vacuform {

// The text that `object` has under `key`; empty where it has none, or something else, or is not an object.
std::string text_of(const nlohmann::json& object, const char* key);

// Whether a text that claims to be JSON has at most so many levels of objects and arrays, and so many values. Looked at before
// it is parsed: the parser takes memory for each level and each value, up to fifty times the text.
struct JsonLimits {
  std::size_t levels = 16, values = 200'000;
};
bool within(std::string_view json, const JsonLimits& limits);

}  // namespace vacuform
