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
#include "worker/inspection/colour_errors.hpp"
#include "worker/inspection/colour_previews.hpp"
#include "worker/inspection/findings_preview.hpp"
#include "worker/inspection/flat_previews.hpp"
#include "worker/inspection/picture_png.hpp"
#include "worker/inspection/segment_colours.hpp"
#include "worker/inspection/side_marks.hpp"
#include "worker/inspection/tiles.hpp"
#include "worker/inspection/vertex_figures.hpp"
#include "worker/inspection/view.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

// One figure per vertex, with its range for colouring.
struct Heat {
  std::vector<double> values;  // NaN where the value is missing
  Scale scale;
};

// The scale ends at the 99th percentile, so that one crumpled triangle does not use up the colour range.
Heat heat_of(std::vector<double> values, const Statistics& statistics, const std::string& quantity) {
  double largest = 1;
  for (const double v : values)
    if (std::isfinite(v)) largest = std::max(largest, v);
  Scale scale = round_scale(1, std::max(1.02, std::min(statistics.p99, largest)), true, quantity);
  scale.open_above = largest > scale.high;
  return {std::move(values), std::move(scale)};
}

Heat thickness_heat(const Finished& job) {
  double least = INFINITY, most = 0;
  for (const double h : job.sheet.thickness) least = std::min(least, h), most = std::max(most, h);
  return {job.sheet.thickness, round_scale(least, most, false, "thickness, mm")};
}

// The scale ends at the 95th percentile, because the few places where the sheet leaves the scan are far worse.
Heat error_heat(const std::vector<double>& values, const PlacedStatistics& over, double least_end,
                const std::string& quantity) {
  Scale scale = round_scale(0, std::max(least_end, over.values.p95), true, quantity);
  scale.open_above = over.values.max > scale.high;
  return {values, std::move(scale)};
}

Heat temperature_heat(const Finished& job) {
  const auto [least, most] = std::minmax_element(job.sheet.temperature.begin(), job.sheet.temperature.end());
  return {job.sheet.temperature, round_scale(*least, *most, false, "temperature, °C")};
}

std::string figures_of(const HeatSummary& heat) {
  return "in the window of the frame: " + decimal(heat.least, 1) + " to " + decimal(heat.most, 1) +
         " °C, mean " + decimal(heat.mean, 1) + " °C" +
         (heat.seconds ? " after " + decimal(*heat.seconds, 0) + " s under the heaters" : "");
}
std::string figures_of(const Distortion& d) {
  return "anisotropy: mean " + decimal(d.anisotropy.mean, 3) + ", 95 % below " +
         decimal(d.anisotropy.p95, 3) + "     area ratio: mean " + decimal(d.area_ratio.mean, 3) +
         ", 95 % below " + decimal(d.area_ratio.p95, 3);
}
// Of the coils if there are any, otherwise of the chart.
std::string figures_of(const Finished& job, CoilSummary CoilTable::*way, const Distortion& chart) {
  if (!job.measured || job.measured->coils.coils.empty()) return figures_of(chart);
  return coils_caption(job.measured->coils, way);
}
std::string ink_note(const Finished& job) {
  return of_colours_alone(job) ? colours_caption(job.colours->area().faded_share())
                               : ink_caption(job.print.ink_printed, job.print.ink_on_head);
}
// Of an error of the colours over everything that is coloured, and where the sheet touches.
std::string figures_of(const PlacedStatistics& whole, const PlacedStatistics& touching) {
  const auto words = [](const Statistics& s) {
    return "mean " + decimal(s.mean, 2) + ", 99 % below " + decimal(s.p99, 2);
  };
  return "where the sheet touches: " + words(touching.values) + "     everywhere: " + words(whole.values);
}
std::string figures_of(const Statistics& s) {
  return "over the inked surface: mean " + decimal(s.mean, 3) + ", 95 % below " + decimal(s.p95, 3) +
         ", 99 % below " + decimal(s.p99, 3) + ", largest " + decimal(s.max, 2);
}

Rgb inked(const Finished& job, const Ink& ink, const Seen& seen) {
  const Rgb colour = in_black(job) ? black_ink : Rgb(ink.r, ink.g, ink.b);
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
      for (std::size_t k = 0; k < 3; ++k)
        from[k] = sheet.rest[static_cast<std::size_t>(c[k])],
        to[k] = sheet.formed[static_cast<std::size_t>(c[k])];
      // Millimetres of flat sheet per millimetre of formed sheet, averaged over directions.
      const SingularValues s = singular_values(from, to);
      shrink_[t] = std::sqrt((1 / (s.largest * s.largest) + 1 / (s.smallest * s.smallest)) / 2);
    }
  }

  FlatPlace operator()(const Seen& seen) const {
    const auto t = static_cast<std::size_t>(seen.triangle);
    const auto& c = sheet_.triangles[t];
    Vector2d rest = Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) rest += seen.weights[k] * sheet_.rest[static_cast<std::size_t>(c[k])];
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
    return print.over_colours(job.pattern.sample(to_pattern * (at.rest - job.flattening.top_rest),
                                                 at.blur_mm / job.alignment.scale),
                              at.rest);
  }
};
struct WithVacuform {
  const SheetPicture& print;
  Ink operator()(const FlatPlace& at) const {
    return std::isfinite(at.blur_mm) ? print.sample(at.rest, at.blur_mm) : Ink{};
  }
};

Rgb hot(const Finished& job, const Heat& heat, const Seen& seen) {
  const auto& c = job.sheet.triangles[static_cast<std::size_t>(seen.triangle)];
  double value = 0;
  for (std::size_t k = 0; k < 3; ++k) value += seen.weights[k] * heat.values[static_cast<std::size_t>(c[k])];
  if (!std::isfinite(value)) return bare(seen);
  // Softer light than on the bare plastic, so that colours can be compared with the bar.
  return (0.5f + 0.52f * seen.light) * viridis((value - heat.scale.low) / (heat.scale.high - heat.scale.low));
}

// The colours of the segments under the ink.
Rgb in_segments(const Finished& job, const SegmentColours& segments, const Ink& ink, const Seen& seen) {
  const auto colour = segments(seen);
  if (!colour) return bare(seen);
  const Rgb over = in_black(job) ? black_ink : Rgb(ink.r, ink.g, ink.b);
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

// The print on the head from five sides.
struct Around {
  Picture whole;
  std::vector<Picture> tiles;
};
Result<Around> views(const Finished& job, const Distortion& after, View& view, const FlatPlaces& flat,
                     const WithVacuform& with, const Context& context) {
  Tiles tiles(static_cast<int>(std::size(five_sides)));
  Around out;
  for (std::size_t i = 0; i < std::size(five_sides); ++i) {
    view.look_from(five_sides[i], tile_width, tile_height, tile_label, 0);
    VACUFORM_TRY(pictures,
                 view.draw(
                     1, [&](const Seen& seen, Rgb* colour) { *colour = inked(job, with(flat(seen)), seen); },
                     context, 0.7 + 0.01 * static_cast<double>(i), 0.71 + 0.01 * static_cast<double>(i)));
    tiles.put(static_cast<int>(i), pictures.front(), side_words(five_sides[i], view.letters()));
    out.tiles.push_back(std::move(pictures.front()));
  }
  out.whole = tiles.finished(
      {"The print on the head from all sides", figures_of(job, &CoilTable::with, after), {}, ink_note(job)});
  return out;
}

// Of the print as it is printed, where that is another picture: as fine as preview-print.png shows it.
constexpr double print_pixel_mm = 0.25;

struct NamedPicture {
  const char* name;
  Picture picture;
};

// The pictures as files, in their order. Frees the pixels.
std::vector<Artifact> encoded(std::vector<NamedPicture>& pictures) {
  std::vector<Artifact> files(pictures.size());
  each_in_parallel(0, static_cast<int>(pictures.size()), [&](int i) {
    NamedPicture& from_pixels = pictures[static_cast<std::size_t>(i)];
    files[static_cast<std::size_t>(i)] = {from_pixels.name, png_of(from_pixels.picture)};
    from_pixels.picture = {};
  });
  return files;
}

}  // namespace

Result<std::vector<Artifact>> previews(const Finished& job, const SheetPicture& print,
                                       const Context& context) {
  const Alignment& alignment = job.alignment;
  const FlatPlaces flat(job.sheet);
  const WithoutVacuform without{job, print};
  const WithVacuform with{print};
  Distortion before, after;
  std::optional<View> seen_from;
  together(
      [&] {
        seen_from.emplace(job.sheet, side_letters(job.mold.findings.left_side), preview_side, preview_side,
                          caption_top, caption_bottom);
      },
      [&] {
        before = distortion(job.surface, job.flattening.triangles,
                            corners_of(job.sheet, job.flattening, job.sheet.rest));
      },
      [&] { after = distortion(job.surface, job.flattening.triangles, corners_of(job.print, alignment)); });
  View& view = *seen_from;
  const Heat anisotropy =
      heat_of(anisotropy_of_vertices(job), before.anisotropy, "anisotropy σ1 / σ2 (1: undistorted)");
  const Heat area = heat_of(area_ratio_of_vertices(job), before.area_ratio, "area ratio (1: undistorted)");
  const Heat thickness = thickness_heat(job);
  const bool uneven = job.heat.source != HeatSource::uniform;
  const Heat temperature = uneven ? temperature_heat(job) : Heat{};

  const std::optional<SegmentColours> segments =
      in_segments(job) ? std::optional<SegmentColours>(job) : std::nullopt;
  const Heat position = job.errors ? error_heat(job.errors->position_of_vertices, job.errors->whole.position,
                                                0.2, "position error, mm")
                                   : Heat{},
             colour = job.errors ? error_heat(job.errors->colour_of_vertices, job.errors->whole.colour, 1,
                                              "colour difference, CIEDE2000")
                                 : Heat{};
  const int of_heat = 6, of_segments = uneven ? 7 : 6, of_errors = of_segments + (segments ? 1 : 0),
            count = of_errors + (job.errors ? 2 : 0);

  VACUFORM_TRY(pictures, view.draw(
                             count,
                             [&](const Seen& seen, Rgb* colours) {
                               const FlatPlace place = flat(seen);
                               const Ink ink = with(place);
                               colours[0] = inked(job, without(place), seen);
                               colours[1] = inked(job, ink, seen);
                               colours[2] = hot(job, anisotropy, seen);
                               colours[3] = hot(job, area, seen);
                               colours[4] = hot(job, thickness, seen);
                               colours[5] = bare(seen);
                               if (uneven) colours[of_heat] = hot(job, temperature, seen);
                               if (segments) colours[of_segments] = in_segments(job, *segments, ink, seen);
                               if (job.errors) {
                                 colours[of_errors] = hot(job, position, seen);
                                 colours[of_errors + 1] = hot(job, colour, seen);
                               }
                             },
                             context, 0.1, 0.7));

  double least = INFINITY;
  for (const double h : job.sheet.element_thickness) least = std::min(least, h);
  const std::string lost = ink_note(job);
  const Caption captions[] = {
      {"The plain pattern, printed as drawn, then formed",
       figures_of(job, &CoilTable::without, before),
       {},
       "Its centre lies where the top of the mold comes to lie, as for the pre-distorted print."},
      {"The pre-distorted print, formed", figures_of(job, &CoilTable::with, after), {}, lost},
      {"Shape distortion, corrected by the print", figures_of(before.anisotropy), anisotropy.scale, ""},
      {"Area distortion, corrected by the print", figures_of(before.area_ratio), area.scale, ""},
      {"Thickness of the formed sheet",
       "from " + decimal(job.settings.sheet.thickness_mm, 2) + " mm; thinnest element " + decimal(least, 3) +
           " mm",
       thickness.scale, ""}};
  const char* names[] = {"preview-without.png", "preview-with.png", "preview-anisotropy.png",
                         "preview-area.png", "preview-thickness.png"};
  VACUFORM_TRY(around, views(job, after, view, flat, with, context));
  std::optional<Picture> original, off_register;
  if (job.errors) {
    VACUFORM_TRY(beside, original_preview(job, view, around.tiles, context));
    original = std::move(beside);
    VACUFORM_TRY(aligned, align_preview(
                              job, view,
                              [&](const Seen& seen, const Vector2d& shift, Rgb* shade) {
                                FlatPlace place = flat(seen);
                                place.rest -= shift;
                                *shade = inked(job, with(place), seen);
                              },
                              context));
    off_register = std::move(aligned);
  }
  view.look_from(View::Side::front, preview_side, preview_side, caption_top, caption_bottom);
  std::vector<NamedPicture> shown;
  shown.push_back({"preview-pattern.png", pattern_preview(job, preview_side)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.76));
  std::optional<SheetPicture> as_printed;
  if (job.print.shortage) as_printed.emplace(job, InkState::printed, print_pixel_mm);
  shown.push_back({"preview-print.png", print_preview(job, as_printed ? *as_printed : print, preview_side)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.77));
  for (std::size_t i = 0; i < 5; ++i) {
    write(captions[i], pictures[i]);
    shown.push_back({names[i], std::move(pictures[i])});
  }
  shown.insert(shown.begin() + 4,
               {"preview-views.png", std::move(around.whole)});  // after both ways of printing
  if (uneven) {
    write({"Temperature of the sheet when it met the mold", figures_of(job.heat), temperature.scale, ""},
          pictures[of_heat]);
    shown.push_back({"preview-temperature.png", std::move(pictures[of_heat])});
  }
  if (segments) {
    Picture& picture = pictures[static_cast<std::size_t>(of_segments)];
    write({"Segments and their seams", figures_of(*job.placement), {}, lost}, picture);
    shown.push_back({"preview-segments.png", std::move(picture)});
  }
  if (job.errors) {
    const auto errors = pictures.begin() + of_errors;
    write({"Position error of the colours, mm",
           figures_of(job.errors->whole.position, job.errors->touching.position), position.scale, ""},
          errors[0]);
    write({"Colour difference from the scan, CIEDE2000",
           figures_of(job.errors->whole.colour, job.errors->touching.colour), colour.scale, ""},
          errors[1]);
    shown.push_back({"preview-original.png", std::move(*original)});
    shown.push_back({"preview-position.png", std::move(errors[0])});
    shown.push_back({"preview-colour.png", std::move(errors[1])});
    shown.push_back({"preview-align.png", std::move(*off_register)});
  }
  std::vector<Warning> warnings = job.mold.warnings;
  warnings.insert(warnings.end(), job.sheet.warnings.begin(), job.sheet.warnings.end());
  if (job.measured)
    warnings.insert(warnings.end(), job.measured->warnings.begin(), job.measured->warnings.end());
  VACUFORM_TRY(findings, findings_preview(warnings, view, std::move(pictures[5]), context));
  shown.push_back({"preview-findings.png", std::move(findings)});
  VACUFORM_CHECK(context.step(Stage::inspection, 0.9));
  return encoded(shown);
}

}  // namespace vacuform
