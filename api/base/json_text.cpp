#include "api/base/json_text.hpp"

#include <nlohmann/json.hpp>

namespace vacuform {

std::string text_of(const nlohmann::json& object, const char* key) {
  const auto it = object.is_object() ? object.find(key) : object.end();
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

bool within(std::string_view json, const JsonLimits& limits) {
  std::size_t level = 0, values = 1;
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_text && c == '\\')
      ++i;
    else if (c == '"')
      in_text = !in_text;
    else if (in_text)
      continue;
    else if (c == '[' || c == '{')
      ++level, ++values;
    else if ((c == ']' || c == '}') && level > 0)
      --level;
    else if (c == ',')
      ++values;
    if (level > limits.levels || values > limits.values) return false;
  }
  return true;
}

}  // namespace vacuform
