// report.html: the report for people, with the same numbers as report.json and the pictures of the job.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// One file that needs nothing else: no script, style and pictures inside; for screens, light and dark, and for A4.
// `report` is the whole of report.json; `files` are the job's artifacts, of which the previews are shown. What the
// report does not have is left out. Every text is escaped. Deterministic.
std::string report_html(const nlohmann::ordered_json& report, const std::vector<Artifact>& files);

// A PNG for an <img>: reduced to `width` pixels, without its first `skipped` rows, in base64. Empty if the bytes are
// not a PNG.
std::string embedded_png(const std::vector<std::uint8_t>& png, int width, int skipped);

}  // namespace vacuform
