// Work that shows its progress and that a signal cancels.
#pragma once

#include <functional>

#include "worker/cli/progress_bar.hpp"
#include "worker/context.hpp"

namespace vacuform::cli {

// Runs `work` with a context whose progress stands on the terminal and that SIGINT and SIGTERM cancel; memory that runs
// out is its error. Gives the exit code, and prints the error of work that failed. One at a time.
int run_interruptible(const std::function<Result<void>(const Context&, ProgressBar&)>& work);

}  // namespace vacuform::cli
