// Artifacts on the disk.
#pragma once

#include <filesystem>
#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Writes them into a folder, which is created when absent. Each is written beside its place and renamed: no half file ever
// has an artifact's name. Errors: unreadable.
Result<void> write_artifacts(const std::filesystem::path& out, const std::vector<Artifact>& files);

}  // namespace vacuform
