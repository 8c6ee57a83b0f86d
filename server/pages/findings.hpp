// What an inspection found, the coils of a layout, and figures of a report, as texts for people. A worker's sandboxed child wrote this JSON: any
// value may be missing or of another type.
#pragma once

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace vacuform {

// What is in the scan as a list of titles and values, from findings.json or report.json, with what was guessed and what
// was left out: a wrong unit is easier seen here than on the formed sheet. Null when neither is there.
nlohmann::ordered_json findings_values(const nlohmann::json& findings);

// The array of a layout in the same form, from layout.json. Null for anything else.
nlohmann::ordered_json layout_values(const nlohmann::json& layout);

// A value deep in JSON, or null; a number of it with so many places, or "-"; a text of it, or the fallback.
const nlohmann::json& at(const nlohmann::json& object, std::initializer_list<const char*> keys);
std::string number(const nlohmann::json& value, int places = 3);
std::string text(const nlohmann::json& value, const char* fallback = "-");

}  // namespace vacuform
