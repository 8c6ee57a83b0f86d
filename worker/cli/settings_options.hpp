// --settings FILE.json and --set group.key=value, the same for every command that takes settings.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/error.hpp"

namespace vacuform::cli {

struct SettingsOptions {
  std::string file;
  std::vector<std::string> assignments;

  void add_to(CLI::App& command);  // this object must outlive the parsing

  // The file's object with the assignments on top, as it is written: checked, and without the defaults.
  // Errors: unreadable, bad_settings, bad_usage.
  Result<nlohmann::json> read() const;
};

}  // namespace vacuform::cli
