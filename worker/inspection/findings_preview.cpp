#include "worker/inspection/findings_preview.hpp"

#include <optional>

#include "worker/inspection/callouts.hpp"
#include "worker/inspection/caption.hpp"

namespace vacuform {

Rgb bare(const Seen& seen) { return seen.light * plastic + Rgb::Constant(seen.gloss); }

Result<Picture> findings_preview(const std::vector<Warning>& warnings, View& view, Picture&& front,
                                 const Context& context) {
  Callouts seen(warnings);
  Callouts hidden = seen.take_hidden(view);
  std::optional<Picture> behind;
  if (!hidden.empty()) {
    view.look_from(View::Side::behind, behind_height, behind_top, 0);
    seen.add(hidden.take_no_better(view));
    if (!hidden.empty()) {
      VACUFORM_TRY(pictures,
                   view.draw(
                       1, [](const Seen& at, Rgb* colour) { *colour = bare(at); }, context, 0.86, 0.9));
      behind = std::move(pictures.front());
      hidden.draw(view, *behind, behind_top, behind_height);
    }
    view.look_from(View::Side::front, preview_side, caption_top, caption_bottom);
  }
  seen.draw(view, front, caption_top, preview_side - caption_bottom);
  write_findings(warnings, front, behind ? &*behind : nullptr);
  return std::move(front);
}

Result<Picture> findings_preview(const Mold& mold, const Context& context) {
  View view(mold.mesh, mold.mesh.vertices, side_letters(mold.findings.left_side), preview_side, preview_side,
            caption_top, caption_bottom);
  VACUFORM_TRY(pictures, view.draw(
                             1, [](const Seen& at, Rgb* colour) { *colour = bare(at); }, context, 0, 0.86));
  return findings_preview(mold.warnings, view, std::move(pictures.front()), context);
}

}  // namespace vacuform
