#include "worker/printing/print.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "api/base/decimal.hpp"
#include "api/base/utf8.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/gap_numbers.hpp"
#include "worker/printing/laid_ink.hpp"
#include "worker/printing/layer_files.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/mold_outline.hpp"
#include "worker/printing/print_pdf.hpp"
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

// What resist covers beyond the part is trimmed off with the sheet. A picture is no reason to refuse the circuits.
Result<void> check_ink(const Layer& layer, std::vector<Warning>& warnings) {
  if (layer.step == PrintStep::resist) return {};
  if (!(layer.ink_printed > 0) && layer.step != PrintStep::picture)
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
    // Layers of one drawing say the same of it.
    for (Warning& warning : layer.source->warnings())
      if (std::none_of(warnings.begin(), warnings.end(), [&](const Warning& said) {
            return said.code == warning.code && said.text == warning.text;
          }))
        warnings.push_back(std::move(warning));
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

const Layer& main_of(const std::vector<Layer>& layers) {
  return *std::find_if(layers.begin(), layers.end(),
                       [](const Layer& layer) { return layer.name == "print"; });
}

// What the marks of all pages of a face keep clear of: the chart and what layers print beyond it.
MarkedPage page_of_face(bool mirrored, const PrintInputs& print, const LaidInk& ink) {
  const InkedSurface& surface = print.charted.surface();
  std::vector<Triangle> chart;
  for (const int t : print.charted.flattening().triangles) chart.push_back(surface.triangles()[t]);
  const auto rest = [&](int v) -> const Vector2d& { return surface.rest()[v]; };
  MarkedPage page{.mirrored = mirrored};
  for (const Triangle& t : chart) {
    page.taken.emplace_back();
    for (const int v : t) page.taken.back().extend(rest(v));
  }
  for (const Layer& layer : print.layers)
    for (const Eigen::AlignedBox2d& box : layer.source->boxes()) page.taken.push_back(box);
  std::vector<std::vector<Vector2d>> rings;
  for (const auto& vertices : border_loops(chart)) {
    rings.emplace_back();
    for (const int v : vertices) rings.back().push_back(rest(v));
  }
  page.outline = mold_outline(rings, grid_spacing_mm(print.settings), ink);
  if (mirrored) {
    for (Eigen::AlignedBox2d& box : page.taken)
      box = {Vector2d(-box.max().x(), box.min().y()), Vector2d(-box.min().x(), box.max().y())};
    for (Line& line : page.outline)
      for (Vector2d& p : line.points) p.x() = -p.x();
  }
  return page;
}

// The layers in the order of printing: the face of the main layer first, step by step; otherwise as they are.
std::vector<std::size_t> order_of_printing(const std::vector<Layer>& layers, InkedFace first) {
  std::vector<std::size_t> order(layers.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto key = [&](const Layer& layer) {
      return std::pair(layer.face != first, layer.step.value_or(PrintStep::conductor));
    };
    return key(layers[a]) < key(layers[b]);
  });
  return order;
}

// What the legend of a page says about its step.
std::string step_text(const Layer& layer, std::size_t number, std::size_t count) {
  if (!layer.step) return {};
  constexpr std::array<const char*, 5> inks{"conductive ink", "dielectric ink", "conductive ink, bridges",
                                            "resist", "picture, in its own colours"};
  return "step " + std::to_string(number) + " of " + std::to_string(count) + ": " +
         inks[static_cast<std::size_t>(*layer.step)];
}

// Makes the marks of each layer, in the order of printing.
class PageMarks {
 public:
  PageMarks(const PrintInputs& inputs, const PrintLabel& label, const LaidInk& ink)
      : inputs_(inputs), label_(label), ink_(ink) {}

  Marks of(const Layer& layer, const std::string& step, Print& print) {
    if (!inputs_.settings.print.marks) return {};
    std::optional<MarkedPage>& face = faces_[layer.mirrored() ? 1 : 0];
    if (!face) face = page_of_face(layer.mirrored(), inputs_, ink_);
    MarkedPage page = *face;
    page.step = step;
    page.numbers = place_numbers(layer.numbers, ink_, layer.mirrored());
    const std::size_t lost = layer.numbers.size() - page.numbers.size();
    Marks marks = lay_out_marks(inputs_.settings, label_, std::move(page));
    if (lost > 0)
      marks.warnings.push_back(
          {.code = "marks-left-out",
           .text = std::to_string(lost) + " of " + std::to_string(layer.numbers.size()) +
                   " numbers of gaps have no place beside their gap that is clear of the ink",
           .figure = Warning::Figure{static_cast<double>(lost), "marks", 0.0},
           .place = layer.name});
    if (!print.ruler_mm) print.ruler_mm = marks.ruler_mm;
    for (const Warning& warning : marks.warnings)
      if (std::none_of(print.warnings.begin(), print.warnings.end(),
                       [&](const Warning& w) { return w.code == warning.code && w.text == warning.text; }))
        print.warnings.push_back(warning);
    return marks;
  }

 private:
  const PrintInputs& inputs_;
  const PrintLabel& label_;
  const LaidInk& ink_;
  std::array<std::optional<MarkedPage>, 2> faces_;  // outer, inner
};

// `printed` is in the order of printing, and so are the pages of the main layer's PDF.
void finish_files(const std::vector<std::size_t>& order, std::vector<PrintedLayer>& printed,
                  const OutputProfile& profile, std::vector<Layer>& layers) {
  std::vector<const PdfPage*> pages;
  for (const PrintedLayer& each : printed) pages.push_back(&each.page);
  const Layer* const main = &main_of(layers);
  for (std::size_t i = 0; i < order.size(); ++i) {
    Layer& layer = layers[order[i]];
    layer.files = {std::move(printed[i].png), std::move(printed[i].svg),
                   make_pdf(&layer == main ? pages : std::vector{pages[i]}, profile)};
  }
}

}  // namespace

const Layer& Print::main() const { return main_of(layers); }

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
  PageMarks page_marks(inputs, label, ink);
  const std::vector<std::size_t> order = order_of_printing(layers, main_of(layers).face);
  std::vector<Marks> marks;
  std::vector<PrintedLayer> printed;
  marks.reserve(layers.size());  // pages refer to them
  printed.reserve(layers.size());
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = layers[order[i]];
    marks.push_back(page_marks.of(layer, step_text(layer, i + 1, layers.size()), print));
    const auto share = [&](std::size_t n) {
      return static_cast<double>(n) / static_cast<double>(layers.size());
    };
    const SubProgress part(context, {Stage::printing, share(i), share(i + 1)});
    VACUFORM_TRY(made, PrintedLayer::make(layer, marks.back(), format, part.context()));
    printed.push_back(std::move(made));
  }
  finish_files(order, printed, inputs.profile, layers);
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  print.layers = std::move(layers);
  print.profile = std::move(inputs.profile);
  return print;
}

}  // namespace vacuform
