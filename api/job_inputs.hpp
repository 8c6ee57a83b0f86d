// Which input files a job has, and what its settings have to do with them: one rule for the service, the pipeline and the
// command line.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "api/base/error.hpp"
#include "api/job.hpp"
#include "api/settings.hpp"

namespace vacuform {

using HasInput = std::function<bool(std::string_view input)>;  // whether it is given

// Whether the settings ask for the file. Nothing for one that is used wherever it is given.
std::optional<bool> asks_for(const Settings& settings, std::string_view input);

// Where the settings leave it open, a file that is given is used: a temperature by heat.source=measured, weights by
// flattening.weights=painted.
void use_inputs(const HasInput& has, Settings& settings);

// Errors: bad_usage (a file that every such job needs is missing), bad_settings (a file is given that the settings do not
// use, or they ask for one that is missing).
Result<void> check_inputs(JobKind kind, const HasInput& has, const Settings& settings);

}  // namespace vacuform
