// Work that shows its progress and that a signal cancels.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "worker/cli/progress_bar.hpp"
#include "worker/pipeline/stage_cache.hpp"
#include "worker/stage/context.hpp"

namespace vacuform::cli {

enum class ProgressAs { bar, json, none };
// --progress bar|json. JSON lines are for the program that runs this one (worker/agent/child.hpp).
CLI::Option* add_progress_option(CLI::App& command, ProgressAs& into);

// Runs `work` with a context whose progress is shown and that SIGINT and SIGTERM cancel; memory that runs
// out is its error. Gives the exit code, and prints the error of work that failed. One at a time.
int run_interruptible(const std::function<Result<void>(const Context&, ProgressBar&)>& work,
                      ProgressAs progress = ProgressAs::bar);

// Stages that an earlier run left in a folder; no stages if its name is empty. Each stage found is reported as
// progress.
StageCache stage_cache(const std::string& folder, ProgressAs progress);

}  // namespace vacuform::cli
