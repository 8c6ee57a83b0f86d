// The input files of a job on the command line.
#pragma once

#include <optional>
#include <string>

#include "worker/pipeline/inputs.hpp"

namespace vacuform::cli {

// Reads a file without the names of people, as the service does, so that both make the same result from it. Nothing
// without a path. Errors: those of read_file() and redact().
Result<std::optional<InputFile>> read_input(const std::string& path, std::uint64_t limit = 1u << 30);

}  // namespace vacuform::cli
