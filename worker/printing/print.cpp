#include "worker/printing/print.hpp"

#include <glib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "worker/decimal.hpp"
#include "worker/printing/ink_on_chart.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/png_writer.hpp"
#include "worker/printing/sheet_raster.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
constexpr double largest_side = 32'000;  // cairo's own limit is 32,767

std::string base64(const std::vector<std::uint8_t>& bytes) {
  std::unique_ptr<gchar, void (*)(gpointer)> text(g_base64_encode(bytes.data(), bytes.size()), g_free);
  return text.get();
}

std::string printable(std::string label) {
  for (char& c : label)
    if (c < ' ' || c > '~') c = '?';
  return label;
}

std::string make_svg(const Settings& settings, const std::string& label, const Print& print,
                     const PixelBox& box, const std::vector<std::uint8_t>& image, const Marks& marks) {
  const std::string w = decimal(settings.sheet.width_mm, 3), h = decimal(settings.sheet.height_mm, 3);
  const double d = print.pixel_mm;
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"" +
      w + "mm\" height=\"" + h + "mm\" viewBox=\"" + decimal(-settings.sheet.width_mm / 2, 3) + " " +
      decimal(-settings.sheet.height_mm / 2, 3) + " " + w + " " + h + "\">\n";
  std::string safe;
  for (const char c : label) safe += c == '&' || c == '<' || c == '>' ? '?' : c;
  svg += "  <title>Vacuform print " + safe + "</title>\n";
  svg += std::string("  <desc>Pre-distorted print at 1:1 for the ") +
         (print.mirrored ? "inner face, mirrored: print on the side that touches the mold"
                         : "outer face, seen from above") +
         ". User units are millimetres; the origin is the sheet's centre, x = s and y = -t before any "
         "mirroring.</desc>\n";
  svg += std::string("  <g id=\"pattern\"") + (print.mirrored ? " transform=\"scale(-1 1)\"" : "") + ">\n";
  svg += "    <image x=\"" + decimal((box.left - 0.5 * print.width) * d, 6) + "\" y=\"" +
         decimal((box.top - 0.5 * print.height) * d, 6) + "\" width=\"" +
         decimal((box.right - box.left) * d, 6) + "\" height=\"" + decimal((box.bottom - box.top) * d, 6) +
         "\" preserveAspectRatio=\"none\" xlink:href=\"data:image/png;base64,";
  svg += base64(image);
  svg +=
      "\"/>\n  </g>\n  <g id=\"marks\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.15\">\n"
      "    <style>text { font-family: \"DejaVu Sans\", sans-serif; fill: #000; stroke: none; }</style>\n";
  svg += svg_of(marks);
  svg += "  </g>\n</svg>\n";
  return svg;
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

}  // namespace

Vector2d pattern_coordinates(const Vector2d& chart, const PatternSettings& settings) {
  const double angle = settings.rotate_deg * M_PI / 180, c = std::cos(angle), s = std::sin(angle);
  const Vector2d d = chart - Vector2d(settings.offset_mm[0], settings.offset_mm[1]);
  return Vector2d(c * d.x() + s * d.y(), -s * d.x() + c * d.y()) / settings.scale;
}

Result<Print> make_print(const FormedSheet& sheet, const Flattening& flattening, const Pattern& pattern,
                         const Settings& settings, const std::string& label, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  Print print;
  print.mirrored = settings.pattern.inked_face == InkedFace::inner;
  print.warnings = pattern.warnings();
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

  print.pattern_uv.assign(sheet.rest.size(), Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (std::size_t i = 0; i < sheet.rest.size(); ++i)
    if (flattening.chart[i].allFinite())
      print.pattern_uv[i] = pattern_coordinates(flattening.chart[i], settings.pattern);

  print.ink_area_mm2 = pattern.ink_mm2();
  print.ink_printed = ink_on_chart(sheet, flattening, print.pattern_uv, pattern);
  if (!(print.ink_printed > 0))
    return fail(Code::unusable_pattern, "none of the drawing's ink falls onto the formed part",
                "pattern.offset_mm",
                "move it nearer to the top of the mold, or give a smaller pattern.width_mm");
  if (print.ink_printed < 0.9995)
    print.warnings.push_back(
        {"ink-off-chart", decimal(100 * (1 - print.ink_printed), 1) +
                              " % of the drawing's ink lies off the formed part and is not printed."});

  const SheetRaster raster(sheet, flattening, print, pattern, settings.print.dpi);
  Marks marks;
  if (settings.print.marks) {
    std::vector<Eigen::AlignedBox2d> taken;
    for (const int t : flattening.triangles) {
      Eigen::AlignedBox2d box;
      for (const int v : sheet.triangles[static_cast<std::size_t>(t)]) {
        const Vector2d& st = sheet.rest[static_cast<std::size_t>(v)];
        box.extend(Vector2d(print.mirrored ? -st.x() : st.x(), st.y()));
      }
      taken.push_back(box);
    }
    marks = lay_out_marks(settings, printable(label), taken);
    print.warnings.insert(print.warnings.end(), marks.warnings.begin(), marks.warnings.end());
  }

  const int channels = pattern.grayscale() ? 1 : 4;
  const PixelBox box = raster.box();
  PngWriter whole(print.width, print.height, channels, settings.print.dpi);
  PngWriter part(box.right - box.left, box.bottom - box.top, channels, settings.print.dpi);
  const int band = raster.band_rows();
  std::vector<std::uint8_t> row(static_cast<std::size_t>(print.width) * static_cast<std::size_t>(channels));
  for (int top = 0; top < print.height; top += band) {
    VACUFORM_CHECK(context.step(Stage::printing, static_cast<double>(top) / print.height));
    const int bottom = std::min(top + band, print.height);
    const std::vector<std::uint8_t> inked = raster.rows(top, bottom);
    std::vector<std::uint8_t> marked;
    if (!marks.marks.empty())
      marked = draw_marks(marks, print.width, print.height, print.pixel_mm, top, bottom - top);
    for (int y = top; y < bottom; ++y) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y - top) * print.width;
      std::copy_n(inked.begin() + at * channels, row.size(), row.begin());
      if (y >= box.top && y < box.bottom)
        part.row(row.data() + static_cast<std::ptrdiff_t>(box.left) * channels);
      if (print.mirrored) reverse(row, channels);
      if (!marked.empty()) lay_over(marked.data() + at, print.width, channels, row.data());
      whole.row(row.data());
    }
  }
  print.png = whole.finish();
  print.svg = make_svg(settings, printable(label), print, box, part.finish(), marks);
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  return print;
}

}  // namespace vacuform
