// The commands of `vacuform`, one source file each. A command writes its errors to stderr as one line
// "vacuform: what (where); fix" and sets the exit code of api/base/error.hpp.
#pragma once

#include <CLI/CLI.hpp>

#include "api/base/error.hpp"

namespace vacuform::cli {

void add_run(CLI::App& app, int& exit_code);        // the whole pipeline, without a server
void add_inspect(CLI::App& app, int& exit_code);    // what is in a scan, without forming anything
void add_layout(CLI::App& app, int& exit_code);     // an array of coils made for a scan, as a pattern
void add_sample(CLI::App& app, int& exit_code);     // writes the bundled head form and coil pattern
void add_submit(CLI::App& app, int& exit_code);     // the same as run, but on a server
void add_converge(CLI::App& app, int& exit_code);   // how much the result depends on the grid
void add_calibrate(CLI::App& app, int& exit_code);  // machine parameters from a measured part
void add_chart(CLI::App& app, int& exit_code);      // a test sheet for the inks, and their curve from it

// Prints the error and returns its exit code.
int refuse(const Error& error);

// The error message for std::bad_alloc.
Error out_of_memory();

}  // namespace vacuform::cli
