// The inputs of a job.
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

// The weight image (dark = less distortion of the chart): PNG, JPEG or SVG. It is read like the pattern and laid over
// the page of the pattern, at its width and with its alignment, centre on centre.
struct WeightsFile {
  std::span<const std::uint8_t> bytes;
  std::string name;  // for messages
};

// The ICC profile of the printed files (worker/printing/output_profile.hpp).
struct IccFile {
  std::span<const std::uint8_t> bytes;
  std::string name;  // for messages
};

struct Inputs {
  std::span<const std::uint8_t> scan;
  std::string scan_name;                  // for messages and the format
  std::span<const std::uint8_t> pattern;  // empty if pattern.source is scan
  std::string pattern_name;
  Settings settings;
  std::optional<MeasuredFile> temperature = {};  // of the sheet; if and only if heat.source is measured
  std::optional<WeightsFile> weights = {};       // if and only if flattening.weights is painted
  std::optional<IccFile> icc = {};               // none: sRGB
  bool sensitivity = false;  // report.json also shows how far errors of the machine move each coil
  std::string reference =
      {};  // of the job (api/job_text.hpp): on the print and in the report, with no other effect
  KeptStages kept = {};  // where to look for and store the results of the scan and forming stages
};

// Reads a whole file. Errors: unreadable, too_large (above `limit` bytes).
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path,
                                            std::uint64_t limit = 1u << 30);

}  // namespace vacuform
