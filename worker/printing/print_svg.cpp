#include "worker/printing/print_svg.hpp"

#include <glib.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "api/base/decimal.hpp"
#include "api/base/markup.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

std::string base64(std::span<const std::uint8_t> bytes) {
  std::unique_ptr<gchar, void (*)(gpointer)> text(g_base64_encode(bytes.data(), bytes.size()), g_free);
  return text.get();
}

// Without trailing zeros.
std::string coordinate(double value) {
  std::string text = decimal(value, 4);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string svg_point(const Vector2d& p) { return coordinate(p.x()) + " " + coordinate(-p.y()); }

bool is_straight(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return ((a + (d - a) / 3) - b).norm() < 1e-6 && ((d - (d - a) / 3) - c).norm() < 1e-6;
}

std::string svg_path(const Curve& curve) {
  const auto& p = curve.points;
  std::string out = std::string("M") + svg_point(p[0]);
  for (std::size_t i = 0; i + 3 < p.size(); i += 3) {
    if (is_straight(p[i], p[i + 1], p[i + 2], p[i + 3]))
      out += std::string("L") + svg_point(p[i + 3]);
    else
      out += std::string("C") + svg_point(p[i + 1]) + " " + svg_point(p[i + 2]) + " " + svg_point(p[i + 3]);
  }
  return curve.closed ? out + "Z" : out;
}

std::string hex(const Colour& c) {
  const auto two = [](double v) {
    const int n = static_cast<int>(std::lround(std::clamp(v, 0.0, 1.0) * 255));
    return std::string{"0123456789abcdef"[n / 16], "0123456789abcdef"[n % 16]};
  };
  return std::string("#") + two(c.r) + two(c.g) + two(c.b);
}

std::string group_of(const PrintedElement& element) {
  std::string out =
      element.id.empty() ? "    <g>\n" : std::string("    <g id=\"") + escaped(element.id) + "\">\n";
  for (const PaintedArea& area : element.areas) {
    out += std::string("      <path fill=\"") + hex(area.colour) + "\"";
    if (area.colour.a < 1) out += std::string(" fill-opacity=\"") + short_decimal(area.colour.a) + "\"";
    if (area.even_odd) out += " fill-rule=\"evenodd\"";
    out += " d=\"";
    for (const Curve& outline : area.outlines) out += svg_path(outline);
    out += "\"/>\n";
  }
  for (const Centreline& line : element.centrelines)
    out += std::string("      <path class=\"centreline\" fill=\"none\" stroke=\"none\" data-width-mm=\"") +
           short_decimal(line.width_mm, 6) + "\" d=\"" + svg_path(line.curve) + "\"/>\n";
  return out + "    </g>\n";
}

std::string image_of(const PlacedPicture& picture) {
  return std::string("    <image x=\"") + decimal(picture.left_mm, 6) + "\" y=\"" +
         decimal(picture.top_mm, 6) + "\" width=\"" + decimal(picture.width_mm, 6) + "\" height=\"" +
         decimal(picture.height_mm, 6) +
         "\" preserveAspectRatio=\"none\" xlink:href=\"data:image/png;base64," + base64(picture.png) +
         "\"/>\n";
}

}  // namespace

PlacedPicture placed_on_page(const PixelBox& box, const PrintGrid& grid, std::span<const std::uint8_t> png) {
  const double d = grid.pixel_mm;
  return {(box.left - 0.5 * grid.width) * d, (box.top - 0.5 * grid.height) * d, (box.right - box.left) * d,
          (box.bottom - box.top) * d, png};
}

std::string make_svg(const PrintPage& page, const PageContent& content) {
  const VectorPrint* const vectors = content.vectors;
  const auto layer = [&](const std::string& name) {
    const bool taken = vectors && std::any_of(vectors->elements.begin(), vectors->elements.end(),
                                              [&](const PrintedElement& e) { return e.id == name; });
    return taken ? name + "-layer" : name;
  };
  const std::string w = decimal(page.size_mm.x(), 3), h = decimal(page.size_mm.y(), 3);
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"" +
      w + "mm\" height=\"" + h + "mm\" viewBox=\"" + decimal(-page.size_mm.x() / 2, 3) + " " +
      decimal(-page.size_mm.y() / 2, 3) + " " + w + " " + h + "\">\n";
  svg += std::string("  <title>Vacuform print ") + escaped(page.label.job) +
         (page.label.reference.empty() ? std::string() : ", reference " + escaped(page.label.reference)) +
         "</title>\n";
  svg += std::string("  <desc>Pre-distorted print at 1:1 for the ") +
         (page.mirrored ? "inner face, mirrored: print on the side that touches the mold"
                        : "outer face, seen from above") +
         ". User units are millimetres; the origin is the sheet's centre, x = s and y = -t before any "
         "mirroring.</desc>\n";
  svg += std::string("  <g id=\"") + layer("pattern") + "\"" +
         (page.mirrored ? " transform=\"scale(-1 1)\"" : "") + ">\n";
  if (content.picture) svg += image_of(*content.picture);
  if (vectors)
    for (const PrintedElement& element : vectors->elements)
      if (!element.areas.empty() || !element.centrelines.empty()) svg += group_of(element);
  svg += std::string("  </g>\n  <g id=\"") + layer("marks") +
         "\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.15\">\n"
         "    <style>text { font-family: \"DejaVu Sans\", sans-serif; fill: #000; stroke: none; }</style>\n";
  svg += svg_of(page.marks);
  return svg + "  </g>\n</svg>\n";
}

}  // namespace vacuform
