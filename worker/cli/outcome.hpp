// What a command tells when a job is done: the summary of its report, and whether a warning is serious. The same for run and
// submit.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace vacuform::cli {

struct OutcomeOptions {
  bool quiet = false, json = false, strict = false;

  // --json, --quiet (not both) and --strict. Gives the first two, so that other options can exclude or need them.
  struct Added {
    CLI::Option *json, *quiet, *strict;
  };
  Added add_to(CLI::App& command);
};

inline constexpr int with_serious_warnings = 3;  // exit code of --strict

// The file as JSON; null if it cannot be read or is not a JSON object.
nlohmann::ordered_json read_report(const std::filesystem::path& file);

// Prints the summary of a report on standard output, as text or as JSON as the options say; `out` is where the files are.
// Prints nothing if the file is not a report.
void tell(const OutcomeOptions& options, const nlohmann::ordered_json& report, const std::string& out);

// 3 with --strict where a warning of the report (or of findings.json) is serious, else 0.
int exit_code_of(const OutcomeOptions& options, const nlohmann::ordered_json& report);

}  // namespace vacuform::cli
