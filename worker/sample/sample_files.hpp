// The files of the bundled samples.
#pragma once

#include <filesystem>
#include <string>

#include "api/base/error.hpp"
#include "worker/sample/sample.hpp"

namespace vacuform {

// Writes the files of a model into a folder, which is made when absent. Model "head": head.stl of that form, and pattern.svg;
// "mask" or "figurine": mask.glb or figurine.glb. Error: unreadable.
Result<void> write_sample(const std::filesystem::path& folder, const std::string& model, HeadForm form);

}  // namespace vacuform
