// What an inspection found, for people, and the way from there to a print.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/store/job.hpp"

namespace vacuform {

// What is in the scan as a list, from findings.json or report.json, with what was guessed and what was left out: a wrong
// unit is easier seen here than on the formed sheet. Empty when neither is there.
std::string findings_html(const nlohmann::json& findings);

// A form that makes the print of an inspection that has succeeded, of its scan and with its settings; empty for any other job.
std::string print_form_html(const Job& job);

// A value deep in JSON, or null; a number of it with so many places, or "-".
const nlohmann::json& at(const nlohmann::json& object, std::initializer_list<const char*> keys);
std::string number(const nlohmann::json& value, int places = 3);

}  // namespace vacuform
