// What the studies of forming (converge, calibrate) are given: a scan, settings, and what they write.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/cli/settings_options.hpp"
#include "worker/studies/preparation.hpp"

namespace vacuform::cli {

struct Study {
  nlohmann::json written;  // settings as they were given, without defaults
  Settings settings;
  InputFile scan;
  std::optional<InputFile> temperature;
};

struct StudyOptions {
  std::string scan, temperature;
  SettingsOptions settings;

  void add_to(CLI::App& command);  // this object must outlive the parsing

  Result<Study> read() const;
};

// Errors: unreadable.
Result<void> write_json(const std::string& path, const nlohmann::ordered_json& value);

}  // namespace vacuform::cli
