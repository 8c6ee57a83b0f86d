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

#include "worker/conductors/array_build.hpp"
#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/inspection/figures.hpp"
#include "worker/placement/length_errors.hpp"
#include "worker/printing/print.hpp"

namespace vacuform {

// A vector drawing, as it is placed and printed.
struct PrintedDrawing {
  const Drawing& drawing;
  const Placement& placement;
  const VectorPrint& vectors;               // all conductors, of both faces
  const Alignment& alignment;               // as drawn on the flat sheet
  const ChartedSurface* reverse = nullptr;  // the other face, if coils lie there
  std::vector<int> faces = {};              // by the elements of the drawing; 1: on the other face
};
// Errors: cancelled.
Result<Measured> measure(const ChartedSurface& charted, const PrintedDrawing& printed,
                         const CoilSettings& settings, const Context& context);

// The results of the stages for one job, as inspection reads them, with their figures.
struct Finished {
  const Settings& settings;
  const Mold& mold;
  const FormedSheet& sheet;
  const InkedSurface& surface;
  const Flattening& flattening;
  const Pattern& pattern;      // what the main layer of the print shows, as drawn
  const Placement& placement;  // of the pattern
  const Print& print;
  const Drawing* placed = nullptr;        // what was placed element by element; null: nothing
  const ArrayBuild* build = nullptr;      // of a vector drawing with loops
  const InkedSurface* reverse = nullptr;  // the other face of the sheet; needed with a build
  LengthErrors lengths = {};              // of the pattern on the formed part
  HeatSummary heat = {};
  Alignment alignment = {};  // of the pattern as drawn on the flat sheet (align_flat())
  std::string label = {};    // of the print, as its marks show it
  Figures figures = {};
};
// Fills in all figures but those of a vector print and of colours, which measure() and colour_errors() find.
void add_chart_figures(Finished& job);

// Whether pictures show all ink in black, its shades as opacity: no layer has another colour.
bool in_black(const Print& print);
inline bool in_segments(const Finished& job) {
  return job.settings.pattern.placement == PatternPlacement::segments;
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

// Over the triangles `chart`, with J from `uv` (one entry for each of them) to the inked surface.
DistortionValues distortion_values(const InkedSurface& surface, const std::vector<int>& chart,
                                   const CornersUv& uv);
Distortion distortion(DistortionValues values);
// Over patches; `of` gives the coordinates of a vertex, mm of the inked surface.
Distortion distortion(const std::vector<const Patch*>& patches,
                      const std::function<Eigen::Vector2d(const Patch&, std::size_t)>& of);

// 1, 2, 2.5 or 5 times a power of ten, not below `least`, which is above 0.
double round_step(double least);
// Even bins from `low` on, about thirty of a round width, to `high`.
struct Bins {
  double low, step;
  int count;
};
Bins even_bins(double low, double high);
// The share of the area in each bin; the last bin includes all larger values.
std::vector<double> shares(const std::vector<Weighted>& values, const Bins& bins);

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
