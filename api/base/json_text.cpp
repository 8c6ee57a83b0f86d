#include "api/base/json_text.hpp"

#include <nlohmann/json.hpp>

namespace vacuform {

std::string text_of(const nlohmann::json& object, const char* key) {
  const auto it = object.is_object() ? object.find(key) : object.end();
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

}  // namespace vacuform
