// HTML from the templates in templates/ (Mustache: {{value}} is escaped, {{{value}}} is HTML already).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace vacuform {

// templates/NAME.mustache filled with an object of strings, truth values, null, objects and lists. An empty string counts
// as false for a section. Numbers are formatted by the caller. {{> name}} stands for the text of another template.
// Throws std::logic_error for what only a bug can cause: a template that does not exist or cannot be parsed, a name in it
// that has no value, a number. From any thread; each template is parsed once.
std::string rendered(std::string_view name, const nlohmann::ordered_json& values);

}  // namespace vacuform
