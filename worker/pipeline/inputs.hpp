// The inputs of a job.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/settings.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/pipeline/stage_cache.hpp"

namespace vacuform {

// Files that check_inputs() (api/job_inputs.hpp) accepts.
struct Inputs {
  InputFile scan;
  Settings settings;
  std::optional<InputFile> pattern = {};
  std::optional<InputFile> temperature = {};  // of the sheet
  // The weight image (dark = less distortion of the chart): PNG, JPEG or SVG. It is read like the pattern and laid over
  // the page of the pattern, at its width and with its alignment, centre on centre.
  std::optional<InputFile> weights = {};
  std::optional<InputFile> icc = {};  // the profile of the printed files; none: sRGB
  bool sensitivity = false;           // report.json also shows how far errors of the machine move each coil
  std::string reference =
      {};  // of the job (api/job_text.hpp): on the print and in the report, with no other effect
  StageCache cache = {};  // where to look for and store the results of the scan and forming stages
};

// Whether a file is given, by the names of api/job.hpp. An empty scan or pattern counts as not given; the readers of others refuse it.
bool has_input(const Inputs& inputs, std::string_view name);

// Reads a whole file. Errors: unreadable, too_large (above `limit` bytes).
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path,
                                            std::uint64_t limit = 1u << 30);

}  // namespace vacuform
