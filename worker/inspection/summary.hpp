// A job in a few lines: what was made, its key figures, its warnings and its files, out of report.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace vacuform {

// {label, reference, out, coils, coils_on_head, ink_printed, ink_on_head, figures {without, with}, warnings,
// serious_warnings, files}. `figures` are those of report.json; `coils` and `coils_on_head` are null if the drawing has
// no coils.
nlohmann::ordered_json summary_json(const nlohmann::ordered_json& report, const std::string& out);

// The same for people, as separate lines, without colours. Ends with a line break.
std::string summary_text(const nlohmann::ordered_json& report, const std::string& out);

// The number of serious warnings in report.json.
int serious_warnings(const nlohmann::ordered_json& report);

}  // namespace vacuform
