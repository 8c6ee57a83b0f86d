// A layout job: an array of coils made for a scan, as a drawing that a print takes.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "worker/coils/array_layout.hpp"
#include "worker/pipeline/inputs.hpp"

namespace vacuform {

struct ScanLayout {
  Array array;
  nlohmann::ordered_json report;  // layout.json, see docs/reference/files.md
};

// Forms the head, or takes the cached one, and lays out the array of settings.layout on it. Errors: those of the stages,
// bad_settings (weights of flattening that need a drawing).
Result<ScanLayout> lay_out_scan(const Inputs& inputs, const Context& context);

// One line: how many coils, their diameter and the distance of their centres.
std::string title_of(const Array& array);

// Writes the artifacts of a layout: pattern.svg and layout.json. Errors: unreadable (the folder).
Result<void> write_layout(const ScanLayout& layout, const std::filesystem::path& out);

}  // namespace vacuform
