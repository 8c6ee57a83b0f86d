#include "api/warning_kinds.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace vacuform {
namespace {

constexpr WarningKind kinds[] = {
    {"bridges-crowded", Severity::serious,
     "Crossings lie so close on a loop that a bridge ends on the dielectric patch of the next one: the loop "
     "is not joined "
     "there.",
     "Set a smaller coils.bridge_overlap_mm or coils.patch_margin_mm, or coils.build=two_faces, or draw "
     "larger loops."},
    {"capacitors-small", Severity::warning,
     "A loop needs capacitors of less than 2 pF: those of the cables and of the head detune it.",
     "Set more coils.gaps or coils.gap_rule=frequency, or draw smaller loops."},
    {"clamp-narrow", Severity::warning,
     "The clamp frame holds only a narrow border of the sheet, which may slip.",
     "Use a larger sheet or a smaller window."},
    {"coil-cut", Severity::serious,
     "Coils of the drawing reach beyond its page, or lie off it. What is beyond the page is not printed.",
     "Make the page (artboard) larger, or move the coils onto it."},
    {"coil-left-out", Severity::serious, "Coils of the drawing lie off the formed part and are not printed.",
     "Move or scale the drawing (pattern.offset_mm, pattern.scale), or lower scan.trim_mm."},
    {"coil-off-head", Severity::serious,
     "Coils lie partly beside the mold: on the platform or the wall around it. Their figures are not "
     "counted.",
     "Move or scale the drawing (pattern.offset_mm, pattern.scale), or lower scan.trim_mm."},
    {"coil-out-of-shape", Severity::warning,
     "Coils on the head come out farther from their own drawn shape than 0.5 % of their diameter.",
     "Move the coil to a smoother place, use a finer sheet.resolution_mm, or pattern.placement=elements."},
    {"coils-close", Severity::warning,
     "Conductors of different loops come nearer to each other on the part than coils.clearance_mm.",
     "Move the loops apart, or set a coils.clearance_mm that the ink and the printer keep."},
    {"coils-coupled", Severity::warning,
     "Neighbours on the head couple by 0.01 or more, or other coils by 0.03 or more. Without coils.decouple "
     "the fix "
     "is to set it.",
     "Raise coils.size_limit, or change the size or the place of the array."},
    {"coils-moved", Severity::warning,
     "Decoupling moved the coils by more than 10 mm from where the drawing puts them.",
     "Check that the coils still cover what they must see, or raise coils.size_limit."},
    {"coils-not-decoupled", Severity::serious,
     "coils.decouple is set, and the drawing has more loops than are decoupled.",
     "Draw fewer loops, or set coils.decouple=false."},
    {"coils-open", Severity::serious,
     "A loop is interrupted where there is no capacitor: its ink ends, or a bridge does not reach it.",
     "Move the drawing onto the part, or set smaller coils.bridge_overlap_mm and coils.patch_margin_mm."},
    {"coils-short", Severity::serious,
     "Loops are joined by ink: a short circuit, and not an array. Traces that cross on one layer of ink are "
     "joined where "
     "they cross.",
     "Set coils.build=bridges or coils.build=two_faces, or name the layers of the drawing after the steps of "
     "printing "
     "(docs/how-to/array.md), or take out the lines that join them."},
    {"coils-spacing", Severity::note,
     "Distances of neighbouring coils on the head differ from the drawing by more than 2 mm RMS. The "
     "figure is the one of the report's table.",
     "Set coils.decouple=true if the coupling of neighbours matters."},
    {"colours-missing", Severity::warning,
     "Colours that the scan file names are not in it or beside it. The part is white there.",
     "Export the scan again with all of its materials and images."},
    {"deep-draw", Severity::warning,
     "The draw is deep for the window or the mold: the sheet thins much and may form webs.",
     "Trim the mold higher (scan.trim_mm)."},
    {"fast-forming", Severity::note,
     "The sheet is extrapolated from two coarse grids. The figure is how far this moves 95 % of what "
     "touches the mold, at most.",
     "Set forming.quality=standard before the part is made."},
    {"file-unusual", Severity::note,
     "The scan file is not as its format demands, or mixes colours in an unusual way. The text says how it "
     "was read.",
     "Look at the previews. Export the scan again if they are wrong."},
    {"flattening-flipped", Severity::serious,
     "Triangles of the chart are folded over. The print is wrong there.",
     "Use flattening.method=symmetric_dirichlet, which never folds."},
    {"flattening-not-converged", Severity::warning,
     "The flattening stopped before it settled. Shapes may be less true than they could be.",
     "Use a finer sheet.resolution_mm or another flattening.method."},
    {"flattening-overlaps", Severity::warning,
     "The chart covers parts of the drawing twice. They are printed twice.",
     "Use pattern.placement=segments, or keep ink away from the foot of the mold."},
    {"gaps-left-out", Severity::serious,
     "Gaps for capacitors have no room between the crossings of their loop, and were left out.",
     "Set fewer coils.gaps, a smaller coils.capacitor, or coils.build=two_faces."},
    {"half-steps", Severity::note,
     "In the usual steps of frame and vacuum the simulated sheet failed or tore. It was formed in half "
     "of them.",
     "Check with a finer sheet.resolution_mm: the thickness may depend on the grid."},
    {"ink-hangs-together", Severity::warning,
     "Loops of a picture touch and cannot be told apart. They are laid as one element.",
     "Give the loops as lines, in an SVG or a DXF."},
    {"ink-not-compensated", Severity::note,
     "print.compensate_ink has no effect: the drawing has no shades of gray.",
     "Leave out print.compensate_ink."},
    {"ink-not-enough", Severity::warning,
     "The scan is so dark where the sheet stretches that full ink is too little. The part is paler "
     "there. The figure is the share of the coloured area.",
     "Lighten the darkest colours of the scan, use a lower mold, or print more ink and give "
     "print.ink_curve."},
    {"ink-off-chart", Severity::serious, "Part of the drawing lies off the formed part and is not printed.",
     "Move or scale the drawing (pattern.offset_mm, pattern.scale)."},
    {"inside-out", Severity::serious,
     "The triangles of the scan face inwards. The scan is turned inside out, or it is a mirror image.",
     "Compare left and right of mold.stl with the patient; then set scan.mirror=no, or scan.mirror=yes "
     "if they are swapped."},
    {"large-hole", Severity::warning, "A large hole of the scan was filled. The mold is a guess there.",
     "Scan the place again, or check the mold there."},
    {"layer-empty", Severity::warning,
     "A layer of the drawing has nothing but white on it. White is no ink, and the layer is not printed.",
     "Draw what the layer prints in any other colour. A white ink is drawn in another colour, too."},
    {"layer-unnamed", Severity::warning,
     "The drawing has layers for steps of printing, and shapes that are on none of them. They are printed "
     "with the first "
     "conductor.",
     "Move them to one of the layers, or name their layer after its step (docs/how-to/array.md), or take "
     "them out."},
    {"layers-as-one", Severity::serious,
     "The drawing has layers for steps of printing, and contains what is only printed as a picture. All of "
     "it is in one layer.",
     "Turn texts and pictures into paths, so that its lines stay lines."},
    {"length-far-off", Severity::serious,
     "Lines come out more than 10 % longer or shorter on the formed part than drawn.",
     "Make the drawing smaller, place it nearer to the top, or give its coils as loops, so that each keeps "
     "its shape."},
    {"length-off", Severity::warning,
     "Lines come out longer or shorter on the formed part than drawn, by more than pattern.length_limit.",
     "Make the drawing smaller, place it nearer to the top, or give its coils as loops, so that each keeps "
     "its shape."},
    {"lines-thin", Severity::warning,
     "Lines are narrower than 0.05 mm, or than half a pixel of the print. They may print faint or broken.",
     "Give the lines the width of the trace that is printed."},
    {"loop-on-bridges", Severity::serious,
     "A closed loop is drawn on a layer of bridges. It is printed, but it is neither placed, measured nor "
     "checked as a coil.",
     "Draw loops on a layer of conductors, of the other face if they must not touch."},
    {"marks-left-out", Severity::warning,
     "Marks would lie on the drawing or off the sheet and are not printed.",
     "Use a larger sheet, or another print.margin_mm."},
    {"mirrored-or-turned", Severity::warning,
     "A person saw the patient's left at +x (scan.left_side). With the face at +y it must be at -x.",
     "Compare mold.stl with the patient: set scan.mirror=yes if left and right are swapped, or set "
     "scan.front to the side of the face."},
    {"not-reached", Severity::warning, "The sheet bridges a hollow of the mold without reaching it.",
     "Drill a vent there, or raise machine.vacuum_kpa."},
    {"outliers", Severity::warning,
     "Single vertices lie far away from the rest of the scan. They are left out.",
     "Look at the mold there, or remove the named vertices from the scan."},
    {"pads-covered", Severity::serious,
     "Resist or a picture is printed over the pads of a port or a capacitor. They cannot be soldered.",
     "Leave an opening over each gap and its pads, or move the gaps (coils.port, coils.gaps). The shapes on "
     "a layer of "
     "resist are ink: call it resist openings if they show what stays free, as programs for boards draw it."},
    {"pattern-as-picture", Severity::note,
     "The SVG holds something that cannot be kept as lines. It is printed as a picture.",
     "Change the named part of the SVG to keep its lines exact."},
    {"pattern-coarse", Severity::warning,
     "The drawing has too few pixels for the print's resolution. Its edges look soft.",
     "Give the drawing with more pixels, or as an SVG."},
    {"pattern-dark", Severity::serious,
     "The ink covers more than half of the drawing's page, or a filled shape lies under all coils and joins "
     "them. A dark background is printed as solid ink.",
     "Remove the background, or make it white or transparent."},
    {"pattern-left-out", Severity::warning,
     "Parts of a DXF are not drawn: texts, dimensions, hatches and other shapes without lines, or layers "
     "that "
     "are off.",
     "Turn what is missing into lines and arcs, or save the drawing as SVG."},
    {"pattern-units", Severity::warning,
     "The SVG has its size in mm or another true unit, but no viewBox: how large its shapes are depends on "
     "the program that made it.",
     "Set pattern.dpi to the pixels an inch of that program, or export the drawing with a viewBox."},
    {"pierced", Severity::serious,
     "The mold stands out of the simulated sheet by more than 0.5 mm, on any grid: a part of it is too "
     "thin for the grid.",
     "Use a finer sheet.resolution_mm, or remove thin parts from the scan."},
    {"pins-not-met", Severity::warning, "A pin of the flattening is farther than 0.1 mm from its place.",
     "Move the pins closer to where the chart puts them, or remove some."},
    {"places-unused", Severity::warning,
     "The drawing is a layout that says where its coils lie on the head, and that was made for another head "
     "or other "
     "settings, or the settings move the drawing.",
     "Lay the coils out again for this scan and these settings."},
    {"plates-small", Severity::serious,
     "Printed capacitors have no room for the capacitance that tunes their loops: they stay above their "
     "frequency.",
     "Use a thinner sheet or one of a higher permittivity, a larger coils.plate_width_mm or frequency, or "
     "coils.capacitor=0805."},
    {"rebuilt", Severity::warning,
     "The surface of the scan was too broken to close and was rebuilt. Details may be lost.",
     "Compare mold.stl with the scan, or repair the scan in a mesh editor."},
    {"reference-incomplete", Severity::warning,
     "The fonts of the print lack characters of the job's reference. The print shows ? in their place.",
     "Write the missing characters onto the print by hand, or use Latin letters and digits."},
    {"seams-not-enough", Severity::note,
     "The cuts of pattern.seams leave segments too distorted. More cuts were added.",
     "Add cuts to pattern.seams."},
    {"segment-distorted", Severity::warning, "A segment stays above pattern.distortion_limit.",
     "Keep ink away from the segment, or use a finer sheet.resolution_mm."},
    {"several-bodies", Severity::warning,
     "The scan contains several large separate bodies that are not several heads, such as a head and "
     "its stand. All of them are in the mold.",
     "Look at the mold, and set scan.body if one of them does not belong to it."},
    {"side-unconfirmed", Severity::warning,
     "Nobody has compared the scan with the patient. The face is taken to be at +y and the patient's "
     "left at -x.",
     "Compare preview-views.png with the patient. Set scan.front if the face is elsewhere, then "
     "scan.left_side=minus_x."},
    {"size-unusual", Severity::warning,
     "The longest side is outside of 60 to 700 mm, although the unit or the size was given. No head is "
     "that small or large.",
     "Measure the longest side of the head, and set scan.units or scan.size_mm if the size is wrong."},
    {"space-contradicted", Severity::warning,
     "The file names the axes of the patient (SPACE=LPS or SPACE=RAS), and the settings place the head "
     "otherwise.",
     "Leave scan.up, scan.front, scan.mirror and the angles at auto and 0 if the file is right. Compare the "
     "mold with the "
     "patient."},
    {"tails-left-out", Severity::warning,
     "Loops have no tails: other conductors, gaps and tails block every way from the port to the edge, or "
     "there is no port.",
     "Set coils.gaps, a smaller coils.tail_width_mm, coils.tails=nearest, another coils.port or "
     "coils.build=two_faces, "
     "or a larger sheet and window."},
    {"thin", Severity::warning, "The sheet becomes thinner than forming.thin_limit.",
     "Use a thicker sheet or a lower mold."},
    {"tilted", Severity::warning,
     "The opening or the flat side on which the scan should stand is tilted by more than 20 degrees. "
     "The figure is the angle. The fix names the turn that makes it level.",
     "Straighten the scan (scan.roll_deg, scan.pitch_deg)."},
    {"too-cold", Severity::serious, "The sheet is colder than the plastic forms when it meets the mold.",
     "Heat the sheet longer."},
    {"too-hot", Severity::serious, "The sheet is hotter than the plastic bears when it meets the mold.",
     "Heat the sheet for a shorter time."},
    {"top-off-chart", Severity::warning,
     "The top of the mold is not on the chart. The drawing is centred on the nearest point that is.",
     "Check where the drawing is centred, and move it with pattern.offset_mm."},
    {"trace-stretched", Severity::warning,
     "Printed lines are stretched by more than the ink bears (coils.stretch_limit).",
     "Move the drawing, use an ink that stretches further, or widen the trace."},
    {"trapped-air", Severity::warning,
     "The sheet shuts in air in a hollow of the mold before it reaches the bottom.",
     "Drill the vents that are listed under vents in report.json and marked in preview-findings.png."},
    {"trim-discards", Severity::warning,
     "The automatic trim keeps less than a third of the height of the scan.",
     "Turn the scan (scan.up), or accept undercuts by giving the trim (scan.trim_mm)."},
    {"undercut", Severity::warning,
     "The mold has places that overhang. The sheet cannot reach them, or the part locks on the mold.",
     "Trim the mold above the undercut (scan.trim_mm), or turn the scan."},
    {"uneven-through", Severity::warning,
     "The two faces of the sheet differ much in temperature when it meets the mold.",
     "Heat the sheet longer with less power, or from both sides."},
    {"units-guessed", Severity::warning,
     "The unit of the scan was guessed, and another unit would make it a possible size too, or the unit "
     "is micrometres, which is rare.",
     "Set scan.units if the size is wrong."},
    {"unstable-stretch", Severity::serious,
     "The sheet stretches beyond what its law can bear. One place may take all the stretch.",
     "Set forming.law=mooney_rivlin, or trim the mold higher (scan.trim_mm)."},
    {"up-guessed", Severity::warning,
     "The shape of the scan does not say clearly which axis points up, or contradicts its format. The "
     "figure is the confidence in the axis that is used. The fix names the other axes that are likely.",
     "Set scan.up if the mold stands wrong."},
    {"webbing", Severity::warning,
     "The sheet is compressed sideways, or hangs over, and tends to fold into webs.",
     "Use a lower mold, or a window nearer to its outline."},
    {"window-close", Severity::warning,
     "The window of the clamp frame is close to the mold. The sheet between them thins much.",
     "Use a larger window (machine.window_width_mm)."},
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

}  // namespace vacuform
