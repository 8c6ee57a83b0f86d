// The files beside a scan that give it its colours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform::cli {

// Packs an OBJ with its MTL, or a PLY, and the images that they name into a zip, as the service takes it. The images lie
// in the folder of the scan or in a folder there. `bytes` becomes the zip and `file` its name; both stay as they are where
// the scan names no such file. Errors: unusable_scan (an OBJ has no vertex colours and its MTL is missing), those of read_file().
Result<void> add_files_beside(std::vector<std::uint8_t>& bytes, std::string& file);

}  // namespace vacuform::cli
