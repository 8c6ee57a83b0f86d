// The inspection stage: everything upstream in, figures, previews and the files that show the result out.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/printing/print.hpp"

namespace vacuform {

// Everything that the stages made of one job, as inspection reads it.
struct Finished {
  const Settings& settings;
  const Mold& mold;
  const FormedSheet& sheet;
  const Flattening& flattening;
  const Pattern& pattern;
  const Print& print;
  HeatSummary heat = {};
};

// A named file of the job's output; the names are those of api/job.hpp.
struct Artifact {
  std::string name;
  std::vector<std::uint8_t> bytes;
};

// Of J, the linear map that takes a flat triangle to one in space. Not finite when the flat one has no area.
struct SingularValues {
  double largest, smallest;
};
SingularValues singular_values(const std::array<Eigen::Vector2d, 3>& from,
                               const std::array<Eigen::Vector3d, 3>& to);

// Area-weighted statistics of one figure over the triangles of the chart (DESIGN's definitions). A percentile
// is the smallest value such that at least its share of the inked area has no larger one. All 0 for an empty
// chart.
struct Statistics {
  double mean = 0, p95 = 0, p99 = 0, max = 0;
};
struct Distortion {
  Statistics anisotropy;  // sigma1 / sigma2 of J from pattern coordinates to the inked surface
  Statistics area_ratio;  // max(sigma1 sigma2, 1 / (sigma1 sigma2))
};
// J from `uv` (per vertex of the sheet) to Flattening::inked, over Flattening::triangles.
// With pre-distortion uv is Flattening::chart, without it FormedSheet::rest.
Distortion distortion(const FormedSheet& sheet, const Flattening& flattening,
                      const std::vector<Eigen::Vector2d>& uv);

// The figures, findings and warnings as they stand in report.json, without the parts that only the caller of
// the pipeline knows (hashes of the inputs, versions, seconds). Keys carry their units; numbers are rounded
// to what is known of them; what does not exist is null.
nlohmann::ordered_json report(const Finished& job);

// Whether this job makes the artifact: all do but preview-temperature.png, which an evenly warm sheet does not need.
bool makes(const Finished& job, const ArtifactKind& kind);

// All other artifacts that the job makes, in the order of api/job.hpp: print.png, print.svg, previews (rendered without a
// display), formed.ply, formed.obj/.mtl, uv-map.obj, mold.stl. Pure and deterministic. Errors: cancelled.
Result<std::vector<Artifact>> artifacts(const Finished& job, const Context& context);

}  // namespace vacuform
