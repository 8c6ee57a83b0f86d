// The scan stage of a job, which is the whole of an inspection: what is in the scan, what mold it makes, and whether that
// goes onto the machine. Seconds, and nothing is formed.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "worker/pipeline/inputs.hpp"
#include "worker/scan/mold.hpp"

namespace vacuform {

// The mold on its plug, made or cached. Of the inputs only the scan is used. Errors: those of make_mold() and on_plug().
Result<Mold> mold_of(const Inputs& inputs, const Context& context);
// All that its shape depends on.
nlohmann::ordered_json mold_made_from(const Inputs& inputs);

struct ScanInspection {
  Mold mold;                     // with the warnings of its fit
  std::optional<Error> problem;  // why it cannot be formed
};
// A mold that does not fit is not an error. Errors: those of mold_of(); bad_settings (of a layout).
Result<ScanInspection> inspect_scan(const Inputs& inputs, const Context& context);

// findings.json: scan and mold as in report.json, "fits", "problem" (null or an error with "place_mm"), "warnings"
// (warning_json.hpp).
nlohmann::ordered_json findings_json(const Inputs& inputs, const ScanInspection& inspection);

// Writes the artifacts of an inspection: preview-findings.png, mold.stl and findings.json. Errors: cancelled, unreadable
// (the folder).
Result<void> write_inspection(const Inputs& inputs, const ScanInspection& inspection,
                              const std::filesystem::path& out, const Context& context);

// Writes the same artifacts for a print that `error` ended after its mold was made. Errors: as mold_of() and
// write_inspection().
Result<void> inspect_failure(const Inputs& inputs, const Error& error, const std::filesystem::path& out,
                             const Context& context);

}  // namespace vacuform
