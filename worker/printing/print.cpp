#include "worker/printing/print.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "api/base/decimal.hpp"
#include "api/base/utf8.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/png/png_writer.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/colour_raster.hpp"
#include "worker/printing/ink_compensation.hpp"
#include "worker/printing/ink_on_chart.hpp"
#include "worker/printing/laid_ink.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/mold_outline.hpp"
#include "worker/printing/patch_map.hpp"
#include "worker/printing/print_pdf.hpp"
#include "worker/printing/print_svg.hpp"
#include "worker/printing/seam_gap.hpp"
#include "worker/printing/sheet_raster.hpp"
#include "worker/printing/vector_raster.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/stage/portion.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
constexpr double largest_side = 32'000;  // cairo's own limit is 32,767

// Helvetica of a PDF has the characters of Latin-1 and few more. All three files show the same text. `lost` counts the
// characters that it cannot show.
std::string in_latin_1(const std::string& text, int& lost) {
  std::u32string points = code_points(text).value_or(std::u32string(text.begin(), text.end()));
  for (char32_t& c : points)
    if (!(c >= ' ' && c <= '~') && !(c > 0xa0 && c <= 0xff)) c = '?', ++lost;
  return utf8(points);
}

PrintLabel printable(const PrintLabel& label, std::vector<Warning>& warnings) {
  int of_job = 0, lost = 0;
  const PrintLabel shown{in_latin_1(label.job, of_job), in_latin_1(label.reference, lost), label.sides};
  if (lost > 0)
    warnings.push_back(
        {.code = "reference-incomplete",
         .text = "The print shows ? for characters of the reference that its fonts lack; the report "
                 "has the whole reference",
         .figure = Warning::Figure{static_cast<double>(lost), "characters", 0.0},
         .place = "the label of the print"});
  return shown;
}

// Lays the marks over a row of the print, as black ink.
void lay_over(const std::uint8_t* marks, int width, int channels, std::uint8_t* row) {
  for (int x = 0; x < width; ++x) {
    const int m = marks[x];
    if (m == 0) continue;
    std::uint8_t* p = row + static_cast<std::ptrdiff_t>(x) * channels;
    if (channels == 1) {
      p[0] = static_cast<std::uint8_t>((p[0] * (255 - m) + 127) / 255);
    } else {
      const int under = (p[3] * (255 - m) + 127) / 255, alpha = m + under;
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>((p[c] * under + alpha / 2) / alpha);
      p[3] = static_cast<std::uint8_t>(alpha);
    }
  }
}

void reverse(std::vector<std::uint8_t>& row, int channels) {
  const std::size_t n = static_cast<std::size_t>(channels), width = row.size() / n;
  for (std::size_t a = 0, b = width - 1; a < b; ++a, --b)
    std::swap_ranges(row.begin() + static_cast<std::ptrdiff_t>(a * n),
                     row.begin() + static_cast<std::ptrdiff_t>(a * n + n),
                     row.begin() + static_cast<std::ptrdiff_t>(b * n));
}

Result<void> measure(const Settings& settings, Print& print) {
  print.mirrored = settings.pattern.inked_face == InkedFace::inner;
  print.pixel_mm = 25.4 / settings.print.dpi;
  // A sheet that is a whole number of pixels wide must not gain one by rounding.
  const double columns = std::ceil(settings.sheet.width_mm / print.pixel_mm - 1e-9);
  const double rows = std::ceil(settings.sheet.height_mm / print.pixel_mm - 1e-9);
  if (columns > largest_side || rows > largest_side) {
    const double side = std::max(settings.sheet.width_mm, settings.sheet.height_mm);
    return fail(
        Code::too_large, "the print would have " + decimal(columns, 0) + " x " + decimal(rows, 0) + " pixels",
        "print.dpi", "give print.dpi of at most " + decimal(std::floor(largest_side * 25.4 / side), 0));
  }
  print.width = static_cast<int>(columns);
  print.height = static_cast<int>(rows);
  return {};
}

std::vector<std::array<Vector2d, 3>> uv_of_corners(const std::vector<Segment>& charts) {
  std::size_t count = 0;
  for (const Segment& chart : charts) count += chart.triangles.size();
  std::vector<std::array<Vector2d, 3>> uv(count);
  for (const Segment& chart : charts)
    for (std::size_t i = 0; i < chart.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        uv[static_cast<std::size_t>(chart.triangles[i])][k] =
            chart.patch.uv[static_cast<std::size_t>(chart.patch.triangles[i][k])];
  return uv;
}

// The charts as one; at a seam the coordinates are those of one of its sides.
Patch whole_region(const ChartedSurface& charted, const Print& print) {
  const InkedSurface& surface = charted.surface();
  const std::vector<int>& triangles = charted.flattening().triangles;
  Patch out{{}, std::vector<Vector2d>(surface.rest().size()), surface.rest(), surface.inked()};
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    out.triangles.push_back(surface.triangles()[static_cast<std::size_t>(triangles[i])]);
    for (std::size_t k = 0; k < 3; ++k)
      out.uv[static_cast<std::size_t>(out.triangles.back()[k])] = print.pattern_uv[i][k];
  }
  return out;
}

Result<void> check_ink(Print& print) {
  if (!(print.ink_printed > 0))
    return fail(Code::unusable_pattern, "none of the drawing's ink falls onto the formed part",
                "pattern.offset_mm",
                "move it nearer to the top of the mold, or give a smaller pattern.width_mm");
  if (print.ink_printed < 0.9995)
    print.warnings.push_back({"ink-off-chart",
                              decimal(100 * (1 - print.ink_printed), 1) +
                                  " % of the drawing's ink lies off the formed part and is not printed.",
                              {},
                              Warning::Figure{100 * (1 - print.ink_printed), "%", 0.0}});
  return {};
}

void extend(Eigen::AlignedBox2d& box, const Vector2d& st, bool mirrored) {
  box.extend(Vector2d(mirrored ? -st.x() : st.x(), st.y()));
}

// The areas that marks must keep clear of, print coordinates: the chart, and what elements paint beyond it.
std::vector<Eigen::AlignedBox2d> taken_by(const Patch& chart, const Print& print) {
  std::vector<Eigen::AlignedBox2d> taken;
  for (const Triangle& t : chart.triangles) {
    taken.emplace_back();
    for (const int v : t) extend(taken.back(), chart.rest[static_cast<std::size_t>(v)], print.mirrored);
  }
  if (!print.vectors) return taken;
  for (const PrintedElement& element : print.vectors->elements)
    for (const PaintedArea& area : element.areas)
      for (const Curve& curve : area.outlines)
        for (std::size_t i = 0; i + 3 < curve.points.size(); i += 3) {
          taken.emplace_back();
          for (std::size_t k = i; k < i + 4; ++k) extend(taken.back(), curve.points[k], print.mirrored);
        }
  return taken;
}

// Adds the areas of the colours of a scan, which reach beyond the chart.
void add_coloured(const SheetColours& colours, bool mirrored, std::vector<Eigen::AlignedBox2d>& taken) {
  const FormedSheet& sheet = colours.sheet();
  for (const int t : colours.triangles()) {
    taken.emplace_back();
    for (const int v : sheet.triangles[static_cast<std::size_t>(t)])
      extend(taken.back(), sheet.rest[static_cast<std::size_t>(v)], mirrored);
  }
}

void add_coloured(const SheetColours& colours, const SheetSettings& sheet, LaidInk& ink) {
  const LaidInk::Grid grid(sheet.width_mm, sheet.height_mm);
  ink.add(ColourRaster(colours, grid.width, grid.height, grid.pixel_mm), 4);
}

// Where the plastic leaves the mold, print coordinates.
std::vector<Line> outline_of_mold(const Patch& chart, double grid_mm, const LaidInk& ink, bool mirrored) {
  std::vector<std::vector<Vector2d>> rings;
  for (const auto& vertices : border_loops(chart.triangles)) {
    rings.emplace_back();
    for (const int v : vertices) rings.back().push_back(chart.rest[static_cast<std::size_t>(v)]);
  }
  std::vector<Line> lines = mold_outline(rings, grid_mm, ink);
  for (Line& line : lines)
    for (Vector2d& p : line.points)
      if (mirrored) p.x() = -p.x();
  return lines;
}

// The files of the part of the print that shows a picture, made along with the whole. PDF stores colour and opacity
// separately.
class PictureFiles {
 public:
  PictureFiles(const PixelBox& box, int channels, double dpi, std::span<const std::uint8_t> icc)
      : box_(box), channels_(channels), whole_(width(), height(), channels, dpi, icc) {
    if (channels != 4) return;
    colour_.emplace(width(), height(), 3, dpi);
    opacity_.emplace(width(), height(), 1, dpi);
    rgb_.resize(3 * static_cast<std::size_t>(width()));
    alpha_.resize(static_cast<std::size_t>(width()));
  }

  // Rows [top, bottom) of the whole print of this width, before any mirroring.
  void rows(int top, int bottom, int width, const std::uint8_t* pixels) {
    const int first = std::max(top, box_.top), last = std::min(bottom, box_.bottom);
    const auto each = [&](auto&& write) {
      for (int y = first; y < last; ++y)
        write(pixels + (static_cast<std::ptrdiff_t>(y - top) * width + box_.left) * channels_);
    };
    const auto whole = [&] { each([&](const std::uint8_t* row) { whole_.row(row); }); };
    if (!colour_) return whole();
    together(
        whole,
        [&] {
          each([&](const std::uint8_t* p) {
            for (std::size_t x = 0; x < alpha_.size(); ++x, p += 4)
              std::copy_n(p, 3, rgb_.begin() + 3 * static_cast<std::ptrdiff_t>(x));
            colour_->row(rgb_.data());
          });
        },
        [&] {
          each([&](const std::uint8_t* p) {
            for (std::size_t x = 0; x < alpha_.size(); ++x) alpha_[x] = p[4 * x + 3];
            opacity_->row(alpha_.data());
          });
        });
  }

  void finish() {
    png = whole_.finish();
    if (!colour_) return;
    rgb_ = colour_->finish();
    alpha_ = opacity_->finish();
  }

  std::vector<std::uint8_t> png;  // as it is in the SVG
  std::span<const std::uint8_t> colour() const { return colour_ ? rgb_ : png; }
  std::span<const std::uint8_t> opacity() const { return alpha_; }

 private:
  int width() const { return box_.right - box_.left; }
  int height() const { return box_.bottom - box_.top; }
  const PixelBox box_;
  const int channels_;
  PngWriter whole_;
  std::optional<PngWriter> colour_, opacity_;
  std::vector<std::uint8_t> rgb_, alpha_;  // a row each; after finish() the whole files
};

// False if there are no shades to compensate.
bool compensate(std::vector<RasterLayer>& layers, const Pattern& pattern) {
  std::vector<const Patch*> patches;
  for (const RasterLayer& layer : layers) patches.push_back(layer.patch);
  const auto gain = ink_gain(patches, pattern);
  if (gain.empty()) return false;
  for (std::size_t i = 0; i < layers.size(); ++i) layers[i].gain = gain[i];
  return true;
}

LaidInk laid_ink(const Print& print, const Placement& placement, const InkParts* parts,
                 const Pattern& pattern, const SheetSettings& sheet) {
  const LaidInk::Grid grid(sheet.width_mm, sheet.height_mm);
  if (print.vectors)
    return LaidInk(VectorRaster(*print.vectors, grid.width, grid.height, grid.pixel_mm, false), grid, 4);
  Print size;
  size.width = grid.width, size.height = grid.height, size.pixel_mm = grid.pixel_mm;
  constexpr int dpi = 600;  // no more samples than needed for the share of ink
  return LaidInk(SheetRaster(layers_of(placement), parts, size, pattern, dpi), grid,
                 pattern.grayscale() ? 1 : 4);
}

// Lays a row of straight RGBA on white, as RGB.
void on_white(const std::vector<std::uint8_t>& rgba, std::vector<std::uint8_t>& rgb) {
  rgb.resize(rgba.size() / 4 * 3);
  std::uint8_t* out = rgb.data();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = rgba[i + 3];
      *out++ = static_cast<std::uint8_t>((rgba[i + k] * a + 255 * (255 - a) + 127) / 255);
    }
}

// Draws the rows and makes their files. `vectors`: of a vector print, else null. `size` holds the size of the print.
Result<Print::Layer> draw(const RowSource& source, const VectorPrint* vectors, const Marks& marks,
                          const Settings& settings, int channels, const PrintLabel& label, const Print& size,
                          const OutputProfile& profile, const Context& context) {
  const std::span<const std::uint8_t> icc = channels == 4 ? profile.icc() : std::span<const std::uint8_t>();
  const PixelBox box = source.box();
  const bool opaque = channels == 4 && settings.print.background == Background::white;
  PngWriter whole(size.width, size.height, opaque ? 3 : channels, settings.print.dpi, icc);
  std::optional<PictureFiles> files;
  if (!vectors) files.emplace(box, channels, settings.print.dpi, icc);
  const int band = source.band_rows();
  std::vector<std::uint8_t> row(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(channels)),
      rgb;
  const auto write = [&](int top, int bottom, const std::vector<std::uint8_t>& inked) {
    std::vector<std::uint8_t> marked;
    if (!marks.marks.empty())
      marked = draw_marks(marks, size.width, size.height, size.pixel_mm, top, bottom - top);
    for (int y = top; y < bottom; ++y) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y - top) * size.width;
      std::copy_n(inked.begin() + at * channels, row.size(), row.begin());
      if (size.mirrored) reverse(row, channels);
      if (!marked.empty()) lay_over(marked.data() + at, size.width, channels, row.data());
      if (opaque) on_white(row, rgb);
      whole.row(opaque ? rgb.data() : row.data());
    }
  };
  // The files of a band are packed while the next band is made.
  std::vector<std::uint8_t> inked, next;
  for (int top = 0; top < size.height + band; top += band) {
    VACUFORM_CHECK(context.step(Stage::printing, std::min(1.0, static_cast<double>(top) / size.height)));
    const int before = top - band, bottom = std::min(top + band, size.height);
    together(
        [&] {
          if (top >= size.height) return;
          next = source.rows(top, bottom);
          if (channels == 4) profile.convert(next);
        },
        [&] {
          if (before >= 0) write(before, std::min(top, size.height), inked);
        },
        [&] {
          if (before >= 0 && files) files->rows(before, std::min(top, size.height), size.width, inked.data());
        });
    inked.swap(next);
  }
  const PrintPage page{{settings.sheet.width_mm, settings.sheet.height_mm}, size.mirrored, label};
  if (!files) {
    Print::Layer layer;
    together([&] { layer.png = whole.finish(); },
             [&] { layer.svg = make_svg(page, vectors, nullptr, marks); },
             [&] { layer.pdf = make_pdf(page, vectors, nullptr, {}, marks, profile); });
    return layer;
  }
  files->finish();
  const double d = size.pixel_mm;
  const auto placed = [&](std::span<const std::uint8_t> png) {
    return PlacedPicture{(box.left - 0.5 * size.width) * d, (box.top - 0.5 * size.height) * d,
                         (box.right - box.left) * d, (box.bottom - box.top) * d, png};
  };
  const PlacedPicture opaque_or_not = placed(files->png), colour = placed(files->colour());
  Print::Layer layer{whole.finish(), {}, {}};
  together([&] { layer.svg = make_svg(page, nullptr, &opaque_or_not, marks); },
           [&] { layer.pdf = make_pdf(page, nullptr, &colour, files->opacity(), marks, profile); });
  return layer;
}

}  // namespace

Result<Print> make_print(const ChartedSurface& charted, const Pattern& pattern, const Drawing* drawing,
                         const Placement& placement, const Settings& settings, const PrintLabel& label,
                         const Context& context, const SheetColours* colours, const OutputProfile& profile) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  const bool of_colours = colours && settings.pattern.source == PatternSource::scan;
  const SheetColours* const below = of_colours ? nullptr : colours;  // in files of their own
  Print print;
  print.profile = profile;
  print.warnings = pattern.warnings();
  VACUFORM_CHECK(measure(settings, print));
  print.pattern_uv = uv_of_corners(placement.charts);
  print.seam_gap_mm = seam_gaps(placement);
  print.ink_area_mm2 = pattern.ink_mm2();
  if (drawing) {
    VACUFORM_TRY(vectors, pull_back(*drawing, placement, settings, context));
    const double lost = vectors.painted_mm2 > 0 ? vectors.lost_mm2 / vectors.painted_mm2 : 1;
    print.ink_printed = lost < 1e-9 ? 1 : std::clamp(1 - lost, 0.0, 1.0);
    print.vectors = std::move(vectors);
  } else {
    print.ink_printed = of_colours ? 1 : ink_on_chart(print.pattern_uv, pattern);
  }
  VACUFORM_CHECK(check_ink(print));

  const std::optional<InkParts> parts =
      drawing || placement.elements.empty() ? std::optional<InkParts>() : InkParts(pattern);
  LaidInk ink = laid_ink(print, placement, parts ? &*parts : nullptr, pattern, settings.sheet);
  print.ink_on_head = print.ink_printed * ink.share_on(charted);
  std::vector<RasterLayer> layers = drawing ? std::vector<RasterLayer>() : layers_of(placement);
  if (settings.print.compensate_ink && !compensate(layers, pattern))
    print.warnings.push_back(
        {.code = "ink-not-compensated",
         .text = "print.compensate_ink has nothing to act on: the drawing has no shades of gray",
         .place = "print.compensate_ink"});
  std::optional<ColourInk> colour;  // of the colours of the scan
  if (colours && settings.print.compensate_colours) {
    colour = colour_ink(charted.surface(), settings.print.ink_curve);
    print.shortage = ink_shortage(*colours, charted.surface(), *colour);
    if (auto warning = warning_of(*print.shortage)) print.warnings.push_back(std::move(*warning));
  }
  const ColourRaster::Compensation compensation{colour ? &*colour : nullptr, InkState::printed};
  Marks marks;
  const PrintLabel shown = printable(label, print.warnings);
  if (settings.print.marks) {
    if (below) add_coloured(*below, settings.sheet, ink);
    const Patch region = whole_region(charted, print);
    auto taken = taken_by(region, print);
    if (colours) add_coloured(*colours, print.mirrored, taken);
    marks = lay_out_marks(settings, shown, taken,
                          outline_of_mold(region, grid_spacing_mm(settings), ink, print.mirrored));
    print.ruler_mm = marks.ruler_mm;
    print.warnings.insert(print.warnings.end(), marks.warnings.begin(), marks.warnings.end());
  }

  std::unique_ptr<RowSource> source;
  if (drawing)
    source = std::make_unique<VectorRaster>(*print.vectors, print.width, print.height, print.pixel_mm,
                                            pattern.grayscale());
  else if (of_colours)
    source =
        std::make_unique<ColourRaster>(*colours, print.width, print.height, print.pixel_mm, compensation);
  else
    source =
        std::make_unique<SheetRaster>(layers, parts ? &*parts : nullptr, print, pattern, settings.print.dpi);
  const VectorPrint* const vectors = print.vectors ? &*print.vectors : nullptr;
  const double begin = drawing ? 0.2 : 0, end = below ? 0.6 : 1;
  const Portion first(context, Stage::printing, begin, end), second(context, Stage::printing, end, 1);
  VACUFORM_TRY(files, draw(*source, vectors, marks, settings, pattern.grayscale() ? 1 : 4, shown, print,
                           profile, first.context()));
  print.png = std::move(files.png);
  print.svg = std::move(files.svg);
  print.pdf = std::move(files.pdf);
  if (below) {
    const ColourRaster raster(*below, print.width, print.height, print.pixel_mm, compensation);
    VACUFORM_TRY(layer, draw(raster, nullptr, marks, settings, 4, shown, print, profile, second.context()));
    print.colours = std::move(layer);
  }
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  return print;
}

Result<Pattern> picture_of(const SheetColours& colours, const SheetSettings& sheet, const Context& context) {
  const double pixel_mm = std::max(0.2, std::max(sheet.width_mm, sheet.height_mm) / 4000);
  const Eigen::Vector2i size(static_cast<int>(std::ceil(sheet.width_mm / pixel_mm - 1e-9)),
                             static_cast<int>(std::ceil(sheet.height_mm / pixel_mm - 1e-9)));
  const ColourRaster raster(colours, size.x(), size.y(), pixel_mm, 1);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(4 * static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
  for (int top = 0; top < size.y(); top += raster.band_rows()) {
    VACUFORM_CHECK(context.step(Stage::printing, static_cast<double>(top) / size.y()));
    const auto band = raster.rows(top, std::min(top + raster.band_rows(), size.y()));
    pixels.insert(pixels.end(), band.begin(), band.end());
  }
  for (std::size_t i = 0; i < pixels.size(); i += 4)
    for (std::size_t k = i; k < i + 3; ++k)
      pixels[k] = static_cast<std::uint8_t>((pixels[k] * pixels[i + 3] + 127) / 255);
  return Pattern::of_picture(size, std::move(pixels), pixel_mm * size.cast<double>(), "scan");
}

}  // namespace vacuform
