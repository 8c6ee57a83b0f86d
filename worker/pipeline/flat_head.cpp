#include "worker/pipeline/flat_head.hpp"

#include <utility>

#include "worker/forming/inked_face.hpp"
#include "worker/pipeline/print_progress.hpp"
#include "worker/placement/cut_lines.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

Result<FlatHead> without_colours(const Inputs& inputs, const InkCoverage& coverage, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_TRY(formed, form_head(inputs, context));
  InkedSurface surface = inked_surface(formed.sheet, s.pattern.inked_face);
  VACUFORM_TRY(flattening, flatten(formed.sheet, surface, formed.mold, s.flattening, context, coverage));
  const SubProgress cutting(context, progress::cutting);
  VACUFORM_TRY(cut, with_cut_lines(std::move(formed.sheet), std::move(surface), std::move(flattening),
                                   s.pattern.seams, cutting.context()));
  formed.sheet = std::move(cut.sheet);
  return FlatHead{
      std::move(formed), std::move(cut.surface), std::move(cut.flattening), std::move(cut.edges), {}};
}

}  // namespace

Result<FlatHead> flat_head(const Inputs& inputs, const InkCoverage& coverage, const Context& context) {
  std::optional<Result<FlatHead>> head;
  std::optional<Result<ColouredScan>> scan;
  // The textures of the scan are unpacked while the head is formed.
  together([&] { head = without_colours(inputs, coverage, context); },
           [&] {
             if (inputs.settings.pattern.source != PatternSource::file)
               scan = read_coloured_scan(inputs.scan.bytes, inputs.scan.name, context.silent());
           });
  VACUFORM_TRY(flat, *std::move(head));
  if (scan) {
    VACUFORM_TRY(colours, *std::move(scan));
    for (Warning& warning : colours.warnings) flat.formed.mold.warnings.push_back(std::move(warning));
    flat.colours = std::move(colours);
  }
  return flat;
}

Result<std::optional<SheetColours>> colours_on_sheet(FlatHead& head, const Inputs& inputs) {
  if (!head.colours) return std::optional<SheetColours>();
  const Settings& s = inputs.settings;
  SheetColours colours(ColouredSurface(*std::move(head.colours), head.formed.mold.placing), head.formed.sheet,
                       colour_reach(s.scan.clearance_mm, s.pattern.fade_mm));
  if (colours.triangles().empty())
    return fail(Code::unusable_surface, "no part of the formed sheet comes near the scan", inputs.scan.name,
                "give a lower scan.trim_mm or a larger pattern.fade_mm");
  return std::optional(std::move(colours));
}

}  // namespace vacuform
