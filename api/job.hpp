// The terms of a job that every program shares: kinds, stages, states and the names of its files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vacuform {

// The result of a job: the print, through all the stages; the findings about a scan, which need only its first stage;
// or an array of coils laid out on the formed head.
enum class JobKind { print, inspection, layout };
inline constexpr std::array<std::string_view, 3> job_kind_names{"print", "inspection", "layout"};
constexpr std::string_view name(JobKind kind) { return job_kind_names[static_cast<std::size_t>(kind)]; }
std::optional<JobKind> job_kind_from(std::string_view name);

// The stages of a job, in order.
enum class Stage { scan, forming, flattening, printing, inspection };
inline constexpr std::array<std::string_view, 5> stage_names{"scan", "forming", "flattening", "printing",
                                                             "inspection"};
constexpr std::string_view name(Stage stage) { return stage_names[static_cast<std::size_t>(stage)]; }
std::optional<Stage> stage_from(std::string_view name);

enum class JobState { queued, running, succeeded, failed, cancelling, cancelled };
inline constexpr std::array<std::string_view, 6> job_state_names{"queued", "running",    "succeeded",
                                                                 "failed", "cancelling", "cancelled"};
constexpr std::string_view name(JobState state) { return job_state_names[static_cast<std::size_t>(state)]; }
std::optional<JobState> job_state_from(std::string_view name);
constexpr bool ended(JobState s) {
  return s == JobState::succeeded || s == JobState::failed || s == JobState::cancelled;
}

// The input files of a job: the same names in the form, the store, the lease and the command line.
struct InputKind {
  std::string_view name;
  std::string_view title;       // one line for people
  std::string_view extensions;  // of what is read, as a file dialog takes them
  std::uint64_t most_bytes;
  bool always = true;  // otherwise optional, or where the settings ask for it
};
inline constexpr std::array<InputKind, 5> input_kinds{{
    {"scan", "Scan of the head", ".stl,.obj,.ply,.off,.glb,.zip", 1ull << 30},
    {"pattern", "Pattern", ".svg,.svgz,.dxf,.png,.jpg,.jpeg,.zip", 256ull << 20},
    {"temperature", "Temperature, where measured", ".csv,.txt,.png", 64ull << 20, false},
    {"weights", "Picture that is dark where the chart is distorted least", ".png,.jpg,.jpeg,.svg",
     64ull << 20, false},
    {"icc", "ICC profile of the printer, RGB", ".icc,.icm", 4ull << 20, false},
}};
// nullptr when no input has that name.
const InputKind* input_kind(std::string_view name);
// Whether every job of that kind needs the input. Others are stored with the job for a later print made from it. A print
// of the colours of the scan (pattern.source=scan) needs no pattern.
constexpr bool needs(JobKind job, const InputKind& input, bool prints_scan = false) {
  return input.always && ((job == JobKind::print && !prints_scan) || input.name == "scan");
}
// Whether a job of that kind reads the input if it has it.
constexpr bool uses(JobKind job, const InputKind& input) {
  return job == JobKind::print || needs(job, input) ||
         (job == JobKind::layout && input.name == "temperature");
}

// The artifacts of a job: the same names from the command line, the API and the web page.
struct ArtifactKind {
  std::string_view name;
  std::string_view media_type;
  std::string_view title;  // one line for people
  bool always = true;      // otherwise only jobs with matching content make it
};
inline constexpr std::array<ArtifactKind, 69> artifact_kinds{{
    {"print.png", "image/png", "The print: pre-distorted pattern, 1:1, exact dpi"},
    {"print.svg", "image/svg+xml", "The print at 1:1 with its marks, user units in mm"},
    {"print.pdf", "application/pdf", "The print at 1:1 with its marks, on a page of the sheet's size"},
    {"print-dielectric.png", "image/png", "The dielectric patches of the bridges, 1:1, exact dpi", false},
    {"print-dielectric.svg", "image/svg+xml",
     "The dielectric patches of the bridges at 1:1, user units in mm", false},
    {"print-dielectric.pdf", "application/pdf",
     "The dielectric patches of the bridges at 1:1, on a page of the sheet's size", false},
    {"print-bridges.png", "image/png", "The bridges over the patches, 1:1, exact dpi", false},
    {"print-bridges.svg", "image/svg+xml", "The bridges over the patches at 1:1, user units in mm", false},
    {"print-bridges.pdf", "application/pdf",
     "The bridges over the patches at 1:1, on a page of the sheet's size", false},
    {"print-resist.png", "image/png", "The resist over the circuits, 1:1, exact dpi", false},
    {"print-resist.svg", "image/svg+xml", "The resist over the circuits at 1:1, user units in mm", false},
    {"print-resist.pdf", "application/pdf",
     "The resist over the circuits at 1:1, on a page of the sheet's size", false},
    {"print-picture.png", "image/png", "The picture of the drawing in its colours, 1:1, exact dpi", false},
    {"print-picture.svg", "image/svg+xml",
     "The picture of the drawing in its colours at 1:1, user units in mm", false},
    {"print-picture.pdf", "application/pdf",
     "The picture of the drawing in its colours at 1:1, on a page of the sheet's size", false},
    {"print-reverse.png", "image/png", "The conductors on the other face, 1:1, exact dpi", false},
    {"print-reverse.svg", "image/svg+xml", "The conductors on the other face at 1:1, user units in mm",
     false},
    {"print-reverse.pdf", "application/pdf",
     "The conductors on the other face at 1:1, on a page of the sheet's size", false},
    {"print-reverse-dielectric.png", "image/png", "The dielectric patches on the other face, 1:1, exact dpi",
     false},
    {"print-reverse-dielectric.svg", "image/svg+xml",
     "The dielectric patches on the other face at 1:1, user units in mm", false},
    {"print-reverse-dielectric.pdf", "application/pdf",
     "The dielectric patches on the other face at 1:1, on a page of the sheet's size", false},
    {"print-reverse-bridges.png", "image/png", "The bridges on the other face, 1:1, exact dpi", false},
    {"print-reverse-bridges.svg", "image/svg+xml", "The bridges on the other face at 1:1, user units in mm",
     false},
    {"print-reverse-bridges.pdf", "application/pdf",
     "The bridges on the other face at 1:1, on a page of the sheet's size", false},
    {"print-reverse-resist.png", "image/png", "The resist on the other face, 1:1, exact dpi", false},
    {"print-reverse-resist.svg", "image/svg+xml", "The resist on the other face at 1:1, user units in mm",
     false},
    {"print-reverse-resist.pdf", "application/pdf",
     "The resist on the other face at 1:1, on a page of the sheet's size", false},
    {"print-reverse-picture.png", "image/png", "The picture on the other face, 1:1, exact dpi", false},
    {"print-reverse-picture.svg", "image/svg+xml", "The picture on the other face at 1:1, user units in mm",
     false},
    {"print-reverse-picture.pdf", "application/pdf",
     "The picture on the other face at 1:1, on a page of the sheet's size", false},
    {"colours.png", "image/png", "The colours of the scan, in register with the print", false},
    {"colours.svg", "image/svg+xml", "The colours of the scan at 1:1, user units in mm", false},
    {"colours.pdf", "application/pdf", "The colours of the scan at 1:1, in register with the print", false},
    {"preview-pattern.png", "image/png", "The drawing"},
    {"preview-print.png", "image/png", "The pre-distorted print on the flat sheet"},
    {"preview-without.png", "image/png", "Formed part with the plain pattern"},
    {"preview-with.png", "image/png", "Formed part with the pre-distorted print"},
    {"preview-views.png", "image/png",
     "The print on the head from the front, the back, both sides and above"},
    {"preview-lengths.png", "image/png", "Length of the drawing's lines on the formed part", false},
    {"preview-shape.png", "image/png", "Shape distortion by forming"},
    {"preview-area.png", "image/png", "Area distortion by forming"},
    {"preview-thickness.png", "image/png", "Thickness of the formed sheet"},
    {"preview-temperature.png", "image/png", "Temperature of the sheet", false},
    {"preview-gap.png", "image/png", "Gap between sheet and mold"},
    {"preview-position.png", "image/png", "Position error of the colours", false},
    {"preview-colour.png", "image/png", "Colour difference from the scan", false},
    {"preview-segments.png", "image/png", "Segments and seams on the formed part", false},
    {"preview-original.png", "image/png", "The scan and the formed part side by side, from five sides",
     false},
    {"preview-align.png", "image/png", "The formed part with the print 0.5 and 1 mm off its marks", false},
    {"preview-findings.png", "image/png", "Where to look before forming: the warnings that have a place"},
    {"formed.ply", "application/octet-stream", "The formed sheet with sheet and pattern coordinates"},
    {"formed.obj", "model/obj", "The formed sheet, textured with the print"},
    {"formed.mtl", "model/mtl", "The material of formed.obj"},
    {"formed.glb", "model/gltf-binary", "The formed sheet for 3D viewers, with and without pre-distortion"},
    {"uv-map.obj", "model/obj", "The formed surface, textured with the pattern"},
    {"mold.stl", "model/stl", "The mold as placed and trimmed, watertight"},
    {"layers.dxf", "image/vnd.dxf", "The layers of the print as outlines, for CAD programs", false},
    {"coils.csv", "text/csv; charset=utf-8", "What to solder: each gap with its capacitor and its place",
     false},
    {"array.json", "application/json", "The loops as circuits: figures, matrices, lines in space", false},
    {"array.nec", "text/plain; charset=utf-8", "The tuned loops as wires, for NEC-2", false},
    {"array.ts", "text/plain; charset=utf-8", "The scattering matrix of the array, Touchstone 2.0", false},
    {"array-marie.msh", "text/plain; charset=utf-8", "The same wires as a mesh, for MARIE", false},
    {"array-marie.json", "application/json", "The capacitors of these wires, for MARIE", false},
    {"array.stl", "model/stl", "The printed conductors as solids on the formed part", false},
    {"findings.json", "application/json",
     "What is in the scan and what mold it makes, of an inspection or a failed print", false},
    {"pattern.svg", "image/svg+xml", "The coils of a layout, as a drawing to print", false},
    {"layout.json", "application/json", "The figures of a layout: sizes, distances, couplings", false},
    {"report.json", "application/json", "What was asked, what was done, the figures, the warnings"},
    {"report.html", "text/html; charset=utf-8", "The report for people: figures, pictures, all settings"},
}};
// Whether every job of that kind that succeeds has the artifact.
constexpr bool due(JobKind job, const ArtifactKind& artifact) {
  if (job == JobKind::print) return artifact.always;
  if (job == JobKind::layout) return artifact.name == "pattern.svg" || artifact.name == "layout.json";
  return artifact.name == "findings.json" || artifact.name == "preview-findings.png" ||
         artifact.name == "mold.stl";
}
// Whether a job of that kind keeps the artifact when it fails: a print that was refused after its mold was made shows
// the mold and the findings, as an inspection does.
constexpr bool explains_failure(JobKind job, const ArtifactKind& artifact) {
  return job == JobKind::print && due(JobKind::inspection, artifact);
}
// The artifact with the figures and warnings of a job of that kind.
constexpr std::string_view report_of(JobKind job) {
  switch (job) {
    case JobKind::print:
      return "report.json";
    case JobKind::inspection:
      return "findings.json";
    case JobKind::layout:
      break;
  }
  return "layout.json";
}
// nullptr when no artifact has that name.
const ArtifactKind* artifact_kind(std::string_view name);

}  // namespace vacuform
