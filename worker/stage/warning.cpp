#include "worker/stage/warning.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace vacuform {
namespace {

constexpr WarningKind kinds[] = {
    {"clamp-narrow", Severity::warning, "Use a larger sheet or a smaller window."},
    {"coil-left-out", Severity::serious,
     "Move or scale the drawing (pattern.offset_mm, pattern.scale), or lower scan.trim_mm."},
    {"coil-off-head", Severity::serious,
     "Move or scale the drawing (pattern.offset_mm, pattern.scale), or lower scan.trim_mm."},
    {"coil-out-of-shape", Severity::warning,
     "Move the coil to a smoother place, use a finer sheet.resolution_mm, or pattern.placement=elements."},
    {"coils-coupled", Severity::warning,
     "Raise coils.size_limit, or change the size or the place of the array."},
    {"coils-moved", Severity::warning,
     "Check that the coils still cover what they must see, or raise coils.size_limit."},
    {"coils-spacing", Severity::note, "Set coils.decouple=true if the coupling of neighbours matters."},
    {"deep-draw", Severity::warning, "Trim the mold higher (scan.trim_mm)."},
    {"fast-forming", Severity::note, "Set forming.quality=standard before the part is made."},
    {"flattening-flipped", Severity::serious,
     "Use flattening.method=symmetric_dirichlet, which never folds."},
    {"flattening-not-converged", Severity::warning,
     "Use a finer sheet.resolution_mm or another flattening.method."},
    {"flattening-overlaps", Severity::warning,
     "Use pattern.placement=segments, or keep ink away from the foot of the mold."},
    {"half-steps", Severity::note,
     "Check with a finer sheet.resolution_mm: the thickness may depend on the grid."},
    {"ink-hangs-together", Severity::warning, "Give an SVG with one group, with an id, for each coil."},
    {"ink-not-compensated", Severity::note, "Leave out print.compensate_ink."},
    {"ink-not-enough", Severity::warning,
     "Lighten the darkest colours of the scan, use a lower mold, or print more ink and give "
     "print.ink_curve."},
    {"ink-off-chart", Severity::serious, "Move or scale the drawing (pattern.offset_mm, pattern.scale)."},
    {"inside-out", Severity::serious,
     "Compare left and right of mold.stl with the patient; then set scan.mirror=no, or scan.mirror=yes if "
     "they are "
     "swapped."},
    {"large-hole", Severity::warning, "Scan the place again, or check the mold there."},
    {"marks-left-out", Severity::warning, "Use a larger sheet, or another print.margin_mm."},
    {"mirrored-or-turned", Severity::warning,
     "Compare mold.stl with the patient: set scan.mirror=yes if left and right are swapped, or set "
     "scan.front to "
     "the side of the face."},
    {"not-reached", Severity::warning, "Drill a vent there, or raise machine.vacuum_kpa."},
    {"outliers", Severity::warning, "Look at the mold there, or remove the named vertices from the scan."},
    {"pattern-as-picture", Severity::note, "Change the named part of the SVG to keep its lines exact."},
    {"pattern-coarse", Severity::warning, "Give the drawing with more pixels, or as an SVG."},
    {"pierced", Severity::serious, "Use a finer sheet.resolution_mm, or remove thin parts from the scan."},
    {"pins-not-met", Severity::warning, "Move the pins closer to where the chart puts them, or remove some."},
    {"rebuilt", Severity::warning, "Compare mold.stl with the scan, or repair the scan in a mesh editor."},
    {"reference-incomplete", Severity::warning,
     "Write the missing characters onto the print by hand, or use Latin letters and digits."},
    {"seams-not-enough", Severity::note, "Add cuts to pattern.seams."},
    {"segment-distorted", Severity::warning,
     "Keep ink away from the segment, or use a finer sheet.resolution_mm."},
    {"several-bodies", Severity::warning,
     "Look at the mold, and set scan.body if one of them does not belong to it."},
    {"side-unconfirmed", Severity::warning,
     "Compare preview-views.png with the patient. Set scan.front if the face is elsewhere, then "
     "scan.left_side=minus_x."},
    {"size-unusual", Severity::warning,
     "Measure the longest side of the head, and set scan.units or scan.size_mm if the size is wrong."},
    {"thin", Severity::warning, "Use a thicker sheet or a lower mold."},
    {"tilted", Severity::warning, "Straighten the scan (scan.roll_deg, scan.pitch_deg)."},
    {"too-cold", Severity::serious, "Heat the sheet longer."},
    {"too-hot", Severity::serious, "Heat the sheet for a shorter time."},
    {"top-off-chart", Severity::warning,
     "Check where the drawing is centred, or use another flattening.region."},
    {"trace-stretched", Severity::warning,
     "Move the drawing, use an ink that stretches further, or widen the trace."},
    {"trapped-air", Severity::warning,
     "Drill the vents that are listed under vents in report.json and marked in preview-findings.png."},
    {"trim-discards", Severity::warning,
     "Turn the scan (scan.up), or accept undercuts by giving the trim (scan.trim_mm)."},
    {"undercut", Severity::warning, "Trim the mold above the undercut (scan.trim_mm), or turn the scan."},
    {"uneven-through", Severity::warning, "Heat the sheet longer with less power, or from both sides."},
    {"units-guessed", Severity::warning, "Set scan.units if the size is wrong."},
    {"unstable-stretch", Severity::serious,
     "Set forming.law=mooney_rivlin, or trim the mold higher (scan.trim_mm)."},
    {"up-guessed", Severity::warning, "Set scan.up if the mold stands wrong."},
    {"webbing", Severity::warning, "Use a lower mold, or a window nearer to its outline."},
    {"window-close", Severity::warning, "Use a larger window (machine.window_width_mm)."},
};
static_assert(std::ranges::is_sorted(kinds, {}, &WarningKind::code));

}  // namespace

std::span<const WarningKind> warning_kinds() { return kinds; }

const WarningKind& warning_kind(std::string_view code) {
  const auto* kind = std::ranges::lower_bound(kinds, code, {}, &WarningKind::code);
  if (kind != std::end(kinds) && kind->code == code) return *kind;
  std::fprintf(stderr, "no such kind of warning: %.*s\n", static_cast<int>(code.size()), code.data());
  std::abort();
}

std::string Warning::what_to_do() const {
  std::string advice = fix.empty() ? std::string(warning_kind(code).fix) : fix;
  if (proposals.empty()) return advice;
  if (advice.ends_with('.')) advice.pop_back();
  return advice_with(advice, proposals) + ".";
}

}  // namespace vacuform
