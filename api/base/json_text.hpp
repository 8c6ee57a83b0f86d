// Texts in JSON that another program wrote.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace vacuform {

// The text that `object` has under `key`; empty where it has none, or something else, or is not an object.
std::string text_of(const nlohmann::json& object, const char* key);

}  // namespace vacuform
