#include "worker/inspection/previews.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "api/base/decimal.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/inspection/canvas.hpp"
#include "worker/inspection/caption.hpp"
#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/colour_previews.hpp"
#include "worker/inspection/findings_preview.hpp"
#include "worker/inspection/flat_previews.hpp"
#include "worker/inspection/heat_maps.hpp"
#include "worker/inspection/picture_png.hpp"
#include "worker/inspection/segment_colours.hpp"
#include "worker/inspection/side_marks.hpp"
#include "worker/inspection/tiles.hpp"
#include "worker/inspection/view.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

std::string figures_of(const Distortion& d) {
  return "shape: mean " + decimal(d.shape.mean, 3) + ", 95 % below " + decimal(d.shape.p95, 3) +
         "     area: mean " + decimal(d.area.mean, 3) + ", 95 % below " + decimal(d.area.p95, 3);
}
// Of the coils if there are any, otherwise of the chart.
std::string figures_of(const Finished& job, Way way) {
  const auto& measured = job.figures.measured;
  return measured && !measured->coils.coils.empty() ? coils_caption(measured->coils, way)
                                                    : figures_of(job.figures[way].chart);
}
std::string ink_note(const Finished& job) {
  const Layer& top = job.print.main();
  const PrintedColours* const colours = top.source->colours();
  return colours ? colours_caption(colours->on_sheet.area().faded_share())
                 : ink_caption(top.ink_printed, top.ink_on_head);
}
Rgb inked(const Finished& job, const Ink& ink, const Seen& seen) {
  const Rgb colour = in_black(job.print) ? black_ink : Rgb(ink.r, ink.g, ink.b);
  return seen.light * (plastic + ink.a * (colour - plastic)) + Rgb::Constant(seen.gloss);
}

// The place on the flat sheet of what is seen.
struct FlatPlace {
  Vector2d rest;   // sheet coordinates, mm
  double blur_mm;  // between samples; not finite where the sheet has no area
};

class FlatPlaces {
 public:
  explicit FlatPlaces(const FormedSheet& sheet) : sheet_(sheet), shrink_(sheet.triangles.size(), 0) {
    for (std::size_t t = 0; t < shrink_.size(); ++t) {
      const auto& c = sheet.triangles[t];
      std::array<Vector2d, 3> from;
      std::array<Eigen::Vector3d, 3> to;
      for (std::size_t k = 0; k < 3; ++k) from[k] = sheet.rest[c[k]], to[k] = sheet.formed[c[k]];
      // Millimetres of flat sheet per millimetre of formed sheet, averaged over directions.
      const SingularValues s = singular_values(from, to);
      shrink_[t] = std::sqrt((1 / (s.largest * s.largest) + 1 / (s.smallest * s.smallest)) / 2);
    }
  }

  FlatPlace operator()(const Seen& seen) const {
    const auto t = static_cast<std::size_t>(seen.triangle);
    const auto& c = sheet_.triangles[t];
    Vector2d rest = Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) rest += seen.weights[k] * sheet_.rest[c[k]];
    return {rest, 1.2 * shrink_[t] * seen.spacing_mm};
  }

 private:
  const FormedSheet& sheet_;
  std::vector<double> shrink_;
};

// The two ways of printing, by the ink at a place of the flat sheet.
struct WithoutVacuform {
  const Finished& job;
  const SheetPicture& print;
  Eigen::Affine2d to_pattern = job.alignment.to_pattern();
  Ink operator()(const FlatPlace& at) const {
    if (!std::isfinite(at.blur_mm)) return {};
    return print.over_lower(job.pattern.sample(to_pattern * (at.rest - job.flattening.top_rest),
                                               at.blur_mm / job.alignment.scale),
                            at.rest, at.blur_mm);
  }
};
struct WithVacuform {
  const SheetPicture& print;
  Ink operator()(const FlatPlace& at) const {
    return std::isfinite(at.blur_mm) ? print.sample(at.rest, at.blur_mm) : Ink{};
  }
};

Rgb hot(const Finished& job, const HeatMap& map, const Seen& seen) {
  const auto& c = job.sheet.triangles[seen.triangle];
  double value = 0;
  for (std::size_t k = 0; k < 3; ++k) value += seen.weights[k] * map.values[c[k]];
  if (!std::isfinite(value)) return bare(seen);
  // Softer light than on the bare plastic, so that colours can be compared with the bar.
  return (0.5f + 0.52f * seen.light) * map.colour(value);
}

// The colours of the segments under the ink.
Rgb in_segments(const Finished& job, const SegmentColours& segments, const Ink& ink, const Seen& seen) {
  const auto colour = segments(seen);
  if (!colour) return bare(seen);
  const Rgb over = in_black(job.print) ? black_ink : Rgb(ink.r, ink.g, ink.b);
  return seen.light * (*colour + ink.a * (over - *colour)) + Rgb::Constant(seen.gloss);
}

std::string figures_of(const Placement& placement) {
  double worst = 1, jump = 0;
  for (const Segment& s : placement.charts) worst = std::max(worst, s.distortion);
  for (const Seam& s : placement.seams) jump = std::max(jump, s.max_jump_mm);
  const auto number = [](std::size_t n, const char* what) {
    return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
  };
  return number(placement.charts.size(), "segment") + ", distorted by at most " + decimal(worst, 3) +
         "     " + number(placement.seams.size(), "seam") + ", across which the drawing jumps by up to " +
         decimal(jump, 1) + " mm";
}

// What the formed part is painted with.
struct Paints {
  const Finished& job;
  FlatPlaces flat;
  WithoutVacuform without;
  WithVacuform with;
  std::vector<HeatMap> maps;
  std::optional<SegmentColours> segments;

  Paints(const Finished& finished, const SheetPicture& print)
      : job(finished), flat(job.sheet), without{job, print}, with{print}, maps(heat_maps(job)) {
    if (in_segments(job)) segments.emplace(job);
  }
};

// The part from the front: the pictures in this order, then one of each heat map.
enum Front : std::size_t { plain, distorted, findings_under, in_parts, of_maps };
Result<std::vector<Picture>> from_the_front(const Paints& paints, View& view, const Context& context) {
  const auto paint = [&](const Seen& seen, Rgb* colours) {
    const FlatPlace place = paints.flat(seen);
    const Ink ink = paints.with(place);
    colours[plain] = inked(paints.job, paints.without(place), seen);
    colours[distorted] = inked(paints.job, ink, seen);
    colours[findings_under] = bare(seen);
    colours[in_parts] = paints.segments ? in_segments(paints.job, *paints.segments, ink, seen) : bare(seen);
    for (std::size_t i = 0; i < paints.maps.size(); ++i)
      colours[of_maps + i] = hot(paints.job, paints.maps[i], seen);
  };
  return view.draw(static_cast<int>(of_maps + paints.maps.size()), paint, context, 0.1, 0.7);
}

// The print on the head from five sides.
struct Around {
  Picture whole;
  std::vector<Picture> tiles;
};
Result<Around> views(const Paints& paints, View& view, const Context& context) {
  const Finished& job = paints.job;
  Tiles tiles(static_cast<int>(std::size(five_sides)));
  Around out;
  for (std::size_t i = 0; i < std::size(five_sides); ++i) {
    view.look_from(five_sides[i], tile_width, tile_height, tile_label, 0);
    VACUFORM_TRY(pictures,
                 view.draw(
                     1,
                     [&](const Seen& seen, Rgb* colour) {
                       *colour = inked(job, paints.with(paints.flat(seen)), seen);
                     },
                     context, 0.7 + 0.01 * static_cast<double>(i), 0.71 + 0.01 * static_cast<double>(i)));
    tiles.put(static_cast<int>(i), pictures.front(), side_words(five_sides[i], view.letters()));
    out.tiles.push_back(std::move(pictures.front()));
  }
  out.whole =
      tiles.finished({"The print on the head from all sides", figures_of(job, Way::with), {}, ink_note(job)});
  return out;
}

// Of the print as it is printed, where that is another picture: as fine as preview-print.png shows it.
constexpr double print_pixel_mm = 0.25;

struct NamedPicture {
  std::string name;
  Picture picture;
};

// The part beside its scan, and off register. Nothing without the colours of a scan.
Result<std::vector<NamedPicture>> beside_the_scan(const Paints& paints, View& view,
                                                  const std::vector<Picture>& tiles, const Context& context) {
  if (!paints.job.figures.errors) return std::vector<NamedPicture>();
  VACUFORM_TRY(original, original_preview(paints.job, view, tiles, context));
  const auto shade = [&](const Seen& seen, const Vector2d& shift, Rgb* colour) {
    FlatPlace place = paints.flat(seen);
    place.rest -= shift;
    *colour = inked(paints.job, paints.with(place), seen);
  };
  VACUFORM_TRY(off_register, align_preview(paints.job, view, shade, context));
  std::vector<NamedPicture> out;
  out.push_back({"preview-original.png", std::move(original)});
  out.push_back({"preview-align.png", std::move(off_register)});
  return out;
}

// The flat sheet with the print as it is printed, which `print` shows unless its ink is compensated.
Picture printed_preview(const Finished& job, const SheetPicture& print) {
  const Layer* const coloured = job.print.coloured();
  if (!coloured || !coloured->source->colours()->ink) return print_preview(job, print, preview_side);
  return print_preview(job, SheetPicture(job, InkState::printed, print_pixel_mm), preview_side);
}

std::vector<Warning> shown_warnings(const Finished& job) {
  std::vector<Warning> warnings = job.mold.warnings;
  warnings.insert(warnings.end(), job.sheet.warnings.begin(), job.sheet.warnings.end());
  if (const auto& measured = job.figures.measured)
    warnings.insert(warnings.end(), measured->warnings.begin(), measured->warnings.end());
  return warnings;
}

// The pictures as files, in their order. Frees the pixels.
std::vector<Artifact> encoded(std::vector<NamedPicture>& pictures) {
  std::vector<Artifact> files(pictures.size());
  each_in_parallel(0, static_cast<int>(pictures.size()), [&](int i) {
    NamedPicture& from_pixels = pictures[i];
    files[i] = {from_pixels.name, png_of(from_pixels.picture)};
    from_pixels.picture = {};
  });
  return files;
}

}  // namespace

Result<std::vector<Artifact>> previews(const Finished& job, const SheetPicture& print,
                                       const Context& context) {
  const Paints paints(job, print);
  View view(job.sheet, side_letters(job.mold.findings.left_side), preview_side, preview_side, caption_top,
            caption_bottom);
  VACUFORM_TRY(front, from_the_front(paints, view, context));
  VACUFORM_TRY(around, views(paints, view, context));
  VACUFORM_TRY(of_scan, beside_the_scan(paints, view, around.tiles, context));
  view.look_from(View::Side::front, preview_side, preview_side, caption_top, caption_bottom);
  std::vector<NamedPicture> shown;
  shown.push_back({"preview-pattern.png", pattern_preview(job, preview_side)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.76));
  shown.push_back({"preview-print.png", printed_preview(job, print)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.77));
  const auto show = [&](const std::string& id, Picture& picture, const Caption& caption) {
    write(caption, picture);
    shown.push_back({"preview-" + id + ".png", std::move(picture)});
  };
  show("without", front[plain],
       {"The plain pattern, printed as drawn, then formed", figures_of(job, Way::without), nullptr,
        "Its centre lies where the top of the mold comes to lie, as for the pre-distorted print."});
  show("with", front[distorted],
       {"The pre-distorted print, formed", figures_of(job, Way::with), nullptr, ink_note(job)});
  shown.push_back({"preview-views.png", std::move(around.whole)});
  if (!job.lengths.pieces.empty())
    shown.push_back({"preview-lengths.png", lengths_preview(job, preview_side)});
  for (std::size_t i = 0; i < paints.maps.size(); ++i) {
    const HeatMap& map = paints.maps[i];
    show(std::string(map.id), front[of_maps + i], {std::string(map.title()), map.figures, &map, ""});
  }
  if (paints.segments)
    show("segments", front[in_parts],
         {"Segments and their seams", figures_of(job.placement), nullptr, ink_note(job)});
  for (NamedPicture& picture : of_scan) shown.push_back(std::move(picture));
  VACUFORM_TRY(findings,
               findings_preview(shown_warnings(job), view, std::move(front[findings_under]), context));
  shown.push_back({"preview-findings.png", std::move(findings)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.9));
  return encoded(shown);
}

}  // namespace vacuform
