// The whole way from a scan and a pattern to the artifacts: the stages in their order. No jobs, no HTTP, no SQL.
#pragma once

#include <filesystem>
#include <functional>

#include "worker/inspection/inspection.hpp"
#include "worker/pipeline/inputs.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// Runs every stage and writes the artifacts of api/job.hpp into `out`, which is created when absent. Each file is
// written beside its place and renamed, so that no half file ever has an artifact's name. The same inputs give the
// same bytes in every file. Errors: those of the stages; unreadable when `out` cannot be written. With does_not_fit,
// forming_failed and unusable_surface, `out` gets the artifacts of an inspection, whose findings.json names the problem.
Result<void> run_pipeline(const Inputs& inputs, const std::filesystem::path& out, const Context& context);

// Runs the stages up to the print and passes what they made to `use`, which must not keep references to it. Errors: those
// of the stages and of `use`.
using UseOfPrint = std::function<Result<std::vector<Artifact>>(const Finished& job)>;
Result<std::vector<Artifact>> with_print(const Inputs& inputs, const UseOfPrint& use, const Context& context);

}  // namespace vacuform
