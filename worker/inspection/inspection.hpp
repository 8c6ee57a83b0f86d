// The inspection stage: takes the results of all earlier stages and makes figures, previews and the files that show the
// result.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/inspection/coil_figures.hpp"
#include "worker/inspection/stretched_traces.hpp"
#include "worker/printing/print.hpp"

namespace vacuform {

// Area-weighted statistics of one figure over the triangles of the chart. A percentile
// is the smallest value such that at least its share of the inked area has no larger one. All 0 for an empty
// chart.
struct Statistics {
  double mean = 0, p95 = 0, p99 = 0, max = 0;
};
// Of values with the areas that have them.
struct Weighted {
  double value, area;
};
Statistics statistics(std::vector<Weighted> values);
struct Distortion {
  Statistics anisotropy;  // sigma1 / sigma2 of J from pattern coordinates to the inked surface
  Statistics area_ratio;  // max(sigma1 sigma2, 1 / (sigma1 sigma2))
};
// The measurements of a vector print.
struct Measured {
  CoilTable coils;
  TraceFigures traces;
  // Over the neighbourhoods of the elements that lie on the head, if the drawing has elements.
  struct Elements {
    Distortion with, without;
  };
  std::optional<Elements> elements = {};
  std::vector<Warning> warnings = {};  // of coils and traces
};
// Errors: cancelled.
Result<Measured> measure(const ChartedSurface& charted, const Drawing& drawing, const Placement& placement,
                         const VectorPrint& print, const Alignment& alignment, const CoilSettings& settings,
                         const Context& context);

struct ColourErrors;  // colour_errors.hpp

// The results of the stages for one job, as inspection reads them.
struct Finished {
  const Settings& settings;
  const Mold& mold;
  const FormedSheet& sheet;
  const InkedSurface& surface;
  const Flattening& flattening;
  const Pattern& pattern;
  const Print& print;
  HeatSummary heat = {};
  Alignment alignment = {};               // of the drawing as drawn on the flat sheet (align_flat())
  const Measured* measured = nullptr;     // of a vector print, else null
  const Placement* placement = nullptr;   // how the drawing is laid; null: on the one chart
  std::string label = {};                 // of the print, as its marks show it
  const SheetColours* colours = nullptr;  // of the scan, if they are printed
  const ColourErrors* errors = nullptr;   // of those colours
};
// Whether the colours of the scan are all that is printed.
inline bool of_colours_alone(const Finished& job) {
  return job.colours && job.settings.pattern.source == PatternSource::scan;
}
// Whether the print is a drawing over the colours of the scan.
inline bool over_colours(const Finished& job) { return job.colours && !of_colours_alone(job); }
// Whether pictures show all ink in black, its shades as opacity.
inline bool in_black(const Finished& job) { return job.pattern.grayscale() && !job.colours; }
inline bool in_segments(const Finished& job) {
  return job.placement && job.settings.pattern.placement == PatternPlacement::segments;
}

// A named file of the job's output; the names are those of api/job.hpp.
struct Artifact {
  std::string name;
  std::vector<std::uint8_t> bytes;
};

// Singular values of J, the linear map from a flat triangle to one in space. Not finite if the flat one has no area.
struct SingularValues {
  double largest, smallest;
};
SingularValues singular_values(const std::array<Eigen::Vector2d, 3>& from,
                               const std::array<Eigen::Vector3d, 3>& to);

// Coordinates of the corners of the triangles Flattening::triangles, one entry each; mm.
using CornersUv = std::vector<std::array<Eigen::Vector2d, 3>>;
// From coordinates of the sheet's vertices. For the drawing printed as it is, those are FormedSheet::rest.
CornersUv corners_of(const FormedSheet& sheet, const Flattening& flattening,
                     const std::vector<Eigen::Vector2d>& uv);
// As printed by `print`, in millimetres of the inked surface.
CornersUv corners_of(const Print& print, const Alignment& alignment);

// The figures of every triangle of the chart (Flattening::triangles), with its area on the inked surface, mm2.
struct DistortionValues {
  std::vector<Weighted> anisotropy, area_ratio;
};
DistortionValues distortion_values(const InkedSurface& surface, const std::vector<int>& chart,
                                   const CornersUv& uv);

// The same over patches; `of` gives the coordinates of a vertex, mm of the inked surface.
Distortion distortion(const std::vector<const Patch*>& patches,
                      const std::function<Eigen::Vector2d(const Patch&, std::size_t)>& of);

// Even bins from `low` on, about thirty of a round width, to the 99th percentile of the values.
struct Bins {
  double low, step;
  int count;
};
Bins even_bins(const std::vector<Weighted>& values, double low);
// The share of the area in each bin; the last bin includes all larger values.
std::vector<double> shares(const std::vector<Weighted>& values, const Bins& bins);

// Over the triangles `chart`, with J from `uv` (one entry for each of them) to the inked surface.
Distortion distortion(const InkedSurface& surface, const std::vector<int>& chart, const CornersUv& uv);

// The figures, findings and warnings as in report.json, without the parts that only the caller of the pipeline knows
// (hashes of the inputs, versions, seconds). Keys contain their units; numbers are rounded to their accuracy; missing
// values are null.
nlohmann::ordered_json report(const Finished& job);

// Whether this job makes the artifact. Every job makes all except preview-temperature.png, which an evenly warm sheet
// does not need, preview-segments.png, which needs segments, the files of the colours, which need a drawing over them,
// preview-original, -position, -colour and -align.png, which need the colours of a scan, and findings.json, whose
// content is in report.json.
bool makes(const Finished& job, const ArtifactKind& kind);

// All other artifacts that the job makes, in the order of api/job.hpp: print.png, print.svg, previews (rendered without
// a display), formed.ply, formed.obj/.mtl, formed.glb, uv-map.obj, mold.stl. Pure and deterministic. Errors: cancelled.
Result<std::vector<Artifact>> artifacts(const Finished& job, const Context& context);

// For a mold without a formed sheet: preview-findings.png and mold.stl. Errors: cancelled.
Result<std::vector<Artifact>> inspection_artifacts(const Mold& mold, const Context& context);

}  // namespace vacuform
