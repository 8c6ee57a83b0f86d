// What a job is made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/pipeline/kept_stages.hpp"

namespace vacuform {

// A picture that says where the chart shall be least distorted, the more the darker: PNG, JPEG or SVG, read as the pattern
// is and laid over the pattern's page, at its width and by its alignment, centre on centre.
struct WeightsFile {
  std::span<const std::uint8_t> bytes;
  std::string name;  // for messages
};

struct Inputs {
  std::span<const std::uint8_t> scan;
  std::string scan_name;  // for messages and the format
  std::span<const std::uint8_t> pattern;
  std::string pattern_name;
  Settings settings;
  std::optional<MeasuredFile> temperature = {};  // of the sheet; only and always with heat.source measured
  std::optional<WeightsFile> weights = {};       // only and always with flattening.weights painted
  bool sensitivity = false;  // report.json tells as well how far each coil lands off by errors of the machine
  KeptStages kept = {};      // where to look for, and leave, what the scan and forming stages make
};

// Reads a whole file. Errors: unreadable, too_large (above `limit` bytes).
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path,
                                            std::uint64_t limit = 1u << 30);

}  // namespace vacuform
