// What an error means to each kind of caller: the problem types of the API (RFC 9457), their HTTP statuses, the exit codes.
#pragma once

#include <optional>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

struct CodeMeaning {
  std::string_view slug;   // stable problem type: /problems/<slug>
  std::string_view title;  // for people
  int http_status;
  int exit_code;            // 0 done, 1 internal fault, 2 bad usage or input, 130 cancelled
  std::string_view detail;  // for people: what it means, in one to three sentences
  std::string_view fix;     // what to do; an error may have a more exact one
};
const CodeMeaning& meaning(Code code);
// The code that a problem type names, from its slug.
std::optional<Code> code_from(std::string_view slug);

}  // namespace vacuform
