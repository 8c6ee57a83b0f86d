// --settings FILE.json and --set group.key=value, both repeatable, and --preview, the same for every command that takes settings.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform::cli {

struct SettingsOptions {
  std::vector<std::string> files;
  std::vector<std::string> assignments;
  bool preview = false;

  void add_to(CLI::App& command);  // this object must outlive the parsing

  // The files' objects, key by key the later over the earlier, with the assignments on top, as they are written: checked
  // together, and without the defaults.
  // Errors: unreadable, bad_settings, bad_usage.
  Result<nlohmann::json> read() const;
};

}  // namespace vacuform::cli
