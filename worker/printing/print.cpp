#include "worker/printing/print.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/base/decimal.hpp"
#include "api/base/utf8.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/laid_ink.hpp"
#include "worker/printing/layer_files.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/mold_outline.hpp"
#include "worker/printing/seam_gap.hpp"
#include "worker/stage/sub_progress.hpp"
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

Result<PrintGrid> grid_of(const Settings& settings) {
  const double pixel_mm = 25.4 / settings.print.dpi;
  // A sheet that is a whole number of pixels wide must not gain one by rounding.
  const double columns = std::ceil(settings.sheet.width_mm / pixel_mm - 1e-9);
  const double rows = std::ceil(settings.sheet.height_mm / pixel_mm - 1e-9);
  if (columns > largest_side || rows > largest_side) {
    const double side = std::max(settings.sheet.width_mm, settings.sheet.height_mm);
    return fail(
        Code::too_large, "the print would have " + decimal(columns, 0) + " x " + decimal(rows, 0) + " pixels",
        "print.dpi", "give print.dpi of at most " + decimal(std::floor(largest_side * 25.4 / side), 0));
  }
  return PrintGrid{static_cast<int>(columns), static_cast<int>(rows), pixel_mm};
}

std::vector<std::array<Vector2d, 3>> uv_of_corners(const std::vector<Segment>& charts) {
  std::size_t count = 0;
  for (const Segment& chart : charts) count += chart.triangles.size();
  std::vector<std::array<Vector2d, 3>> uv(count);
  for (const Segment& chart : charts)
    for (std::size_t i = 0; i < chart.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        uv[chart.triangles[i]][k] = chart.patch.uv[chart.patch.triangles[i][k]];
  return uv;
}

Result<void> check_ink(const Layer& layer, std::vector<Warning>& warnings) {
  if (!(layer.ink_printed > 0))
    return fail(Code::unusable_pattern, "none of the drawing's ink falls onto the formed part",
                "pattern.offset_mm",
                "move it nearer to the top of the mold, or give a smaller pattern.width_mm");
  if (layer.ink_printed < 0.9995)
    warnings.push_back({"ink-off-chart",
                        decimal(100 * (1 - layer.ink_printed), 1) +
                            " % of the drawing's ink lies off the formed part and is not printed.",
                        {},
                        Warning::Figure{100 * (1 - layer.ink_printed), "%", 0.0}});
  return {};
}

Result<void> check_inks(std::vector<Layer>& layers, const PrintSettings& settings,
                        std::vector<Warning>& warnings) {
  for (Layer& layer : layers) {
    for (Warning& warning : layer.source->warnings()) warnings.push_back(std::move(warning));
    layer.ink_printed = layer.source->ink_printed();
    VACUFORM_CHECK(check_ink(layer, warnings));
  }
  const auto compensates = [](const Layer& layer) { return layer.source->compensates_shades(); };
  if (settings.compensate_ink && std::none_of(layers.begin(), layers.end(), compensates))
    warnings.push_back(
        {.code = "ink-not-compensated",
         .text = "print.compensate_ink has nothing to act on: the drawing has no shades of gray",
         .place = "print.compensate_ink"});
  for (const Layer& layer : layers)
    if (const PrintedColours* colours = layer.source->colours(); colours && colours->shortage)
      if (auto warning = warning_of(*colours->shortage)) warnings.push_back(std::move(*warning));
  return {};
}

// The ink of all layers. Fills in how much of that of each lies on the head.
LaidInk lay_ink(const ChartedSurface& charted, const SheetSettings& sheet, std::vector<Layer>& layers) {
  const PrintGrid grid = LaidInk::grid_of(sheet.width_mm, sheet.height_mm);
  std::optional<LaidInk> all;
  for (Layer& layer : layers) {
    LaidInk ink(*layer.source->laid(grid), grid);
    layer.ink_on_head = layer.ink_printed * ink.share_on(charted);
    if (all)
      all->add(ink);
    else
      all = std::move(ink);
  }
  return *std::move(all);
}

// The marks of a face. They keep clear of the chart and of what layers print beyond it.
Marks marks_of_face(bool mirrored, const PrintInputs& print, const PrintLabel& label, const LaidInk& ink) {
  const InkedSurface& surface = print.charted.surface();
  std::vector<Triangle> chart;
  for (const int t : print.charted.flattening().triangles) chart.push_back(surface.triangles()[t]);
  const auto rest = [&](int v) -> const Vector2d& { return surface.rest()[v]; };
  std::vector<Eigen::AlignedBox2d> taken;
  for (const Triangle& t : chart) {
    taken.emplace_back();
    for (const int v : t) taken.back().extend(rest(v));
  }
  for (const Layer& layer : print.layers)
    for (const Eigen::AlignedBox2d& box : layer.source->boxes()) taken.push_back(box);
  std::vector<std::vector<Vector2d>> rings;
  for (const auto& vertices : border_loops(chart)) {
    rings.emplace_back();
    for (const int v : vertices) rings.back().push_back(rest(v));
  }
  std::vector<Line> outline = mold_outline(rings, grid_spacing_mm(print.settings), ink);
  if (mirrored) {
    for (Eigen::AlignedBox2d& box : taken)
      box = {Vector2d(-box.max().x(), box.min().y()), Vector2d(-box.min().x(), box.max().y())};
    for (Line& line : outline)
      for (Vector2d& p : line.points) p.x() = -p.x();
  }
  return lay_out_marks(print.settings, mirrored, label, taken, std::move(outline));
}

}  // namespace

const Layer& Print::main() const {
  return *std::find_if(layers.begin(), layers.end(),
                       [](const Layer& layer) { return layer.name == "print"; });
}

const Layer* Print::coloured() const {
  const auto found = std::find_if(layers.begin(), layers.end(),
                                  [](const Layer& layer) { return layer.source->colours() != nullptr; });
  return found == layers.end() ? nullptr : &*found;
}

Result<Print> make_print(PrintInputs inputs, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  const Settings& settings = inputs.settings;
  std::vector<Layer>& layers = inputs.layers;
  Print print;
  VACUFORM_TRY(grid, grid_of(settings));
  print.grid = grid;
  print.pattern_uv = uv_of_corners(inputs.placement.charts);
  print.seam_gap_mm = seam_gaps(inputs.placement);
  VACUFORM_CHECK(check_inks(layers, settings.print, print.warnings));
  const LaidInk ink = lay_ink(inputs.charted, settings.sheet, layers);
  const PrintLabel label = printable(inputs.label, print.warnings);
  const PrintFormat format{settings, grid, label, inputs.profile};
  std::array<std::optional<Marks>, 2> marks;  // of the outer and of the inner face
  for (std::size_t i = 0; i < layers.size(); ++i) {
    Layer& layer = layers[i];
    std::optional<Marks>& of_face = marks[layer.mirrored() ? 1 : 0];
    if (!of_face) {
      of_face = settings.print.marks ? marks_of_face(layer.mirrored(), inputs, label, ink) : Marks();
      print.warnings.insert(print.warnings.end(), of_face->warnings.begin(), of_face->warnings.end());
      if (!print.ruler_mm) print.ruler_mm = of_face->ruler_mm;
    }
    const auto share = [&](std::size_t n) {
      return static_cast<double>(n) / static_cast<double>(layers.size());
    };
    const SubProgress part(context, {Stage::printing, share(i), share(i + 1)});
    VACUFORM_TRY(files, layer_files(layer, *of_face, format, part.context()));
    layer.files = std::move(files);
  }
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  print.layers = std::move(layers);
  print.profile = std::move(inputs.profile);
  return print;
}

}  // namespace vacuform
