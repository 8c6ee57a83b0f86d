#include "worker/pattern/svg_shape.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "api/base/text.hpp"
#include "worker/pattern/svg_path.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

std::optional<Colour> paint_of(const Style& style, Property paint, Property opacity, double whole,
                               Refusal& refusal) {
  const std::string_view text = style[paint];
  if (text == "none") return std::nullopt;
  if (text.starts_with("url(") || text.starts_with("context-")) {
    refusal.because("gradients or patterns as colours", "give plain colours");
    return std::nullopt;
  }
  auto colour = text == "currentColor" || text == "currentcolor" ? svg_colour(style[Property::color])
                                                                 : svg_colour(text);
  // Inkscape and Illustrator may add a second colour for print after it.
  if (!colour) colour = svg_colour(text.substr(0, text.find(' ')));
  if (!colour) return std::nullopt;
  colour->a *= svg_opacity(style[opacity]).value_or(1) * whole;
  if (!(colour->a > 0)) return std::nullopt;
  return colour;
}

void read_dashes(const Style& style, double scale, const Vector2d& viewport, Stroke& stroke,
                 Refusal& refusal) {
  std::string_view list = trimmed(style[Property::stroke_dasharray]);
  if (list == "none") return;
  double sum = 0;
  while (!list.empty()) {
    const auto end = std::min(list.find_first_of(", \t\r\n"), list.size());
    if (end > 0) {
      const auto dash = svg_length(list.substr(0, end), LengthOf::diagonal, viewport);
      // SVG draws a continuous line if a dash is invalid.
      if (!dash || *dash < 0) return stroke.dashes_mm.clear();
      stroke.dashes_mm.push_back(*dash * scale);
      sum += *dash;
    }
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  if (!(sum > 0)) return stroke.dashes_mm.clear();
  if (stroke.dashes_mm.size() > 1000)
    return refusal.because("lines of more than 1000 dashes and gaps", "simplify them");
  if (stroke.dashes_mm.size() % 2 == 1) {
    const auto once = stroke.dashes_mm;
    stroke.dashes_mm.insert(stroke.dashes_mm.end(), once.begin(), once.end());
  }
  const auto offset = svg_length(style[Property::stroke_dashoffset], LengthOf::diagonal, viewport);
  stroke.dash_offset_mm = offset.value_or(0) * scale;
}

}  // namespace

std::optional<double> length_of(const pugi::xml_node& node, const char* name, LengthOf of,
                                const Vector2d& viewport, Refusal& refusal) {
  const std::string_view text = trimmed(node.attribute(name).value());
  if (text.empty() || text == "auto") return std::nullopt;
  const auto value = svg_length(text, of, viewport);
  if (!value) refusal.because("lengths that cannot be read", "give them in mm");
  return value;
}

std::vector<Curve> curves_of(const pugi::xml_node& node, const Vector2d& viewport, std::size_t most,
                             Refusal& refusal) {
  const std::string_view name = local_name(node);
  const auto length = [&](const char* key, LengthOf of) {
    return length_of(node, key, of, viewport, refusal);
  };
  const auto x = [&](const char* key) { return length(key, LengthOf::width).value_or(0); };
  const auto y = [&](const char* key) { return length(key, LengthOf::height).value_or(0); };
  if (name == "path") {
    return svg_path(node.attribute("d").value(), most);
  }
  if (name == "circle") {
    const double r = length("r", LengthOf::diagonal).value_or(0);
    if (!(r > 0)) return {};
    return svg_ellipse({x("cx"), y("cy")}, {r, r});
  }
  auto rx = length("rx", LengthOf::width), ry = length("ry", LengthOf::height);
  if (!rx) rx = ry;
  if (!ry) ry = rx;
  const Vector2d radii(rx.value_or(0), ry.value_or(0));
  if (name == "ellipse") {
    if (!(radii.minCoeff() > 0)) return {};
    return svg_ellipse({x("cx"), y("cy")}, radii);
  }
  if (name == "rect") {
    const Vector2d size(x("width"), y("height"));
    if (!(size.minCoeff() > 0)) return {};
    return svg_rectangle({x("x"), y("y")}, size, radii.cwiseMax(0));
  }
  if (name == "line") return svg_polyline({x("x1"), y("y1"), x("x2"), y("y2")}, false);
  if (name != "polyline" && name != "polygon") return {};
  const std::string_view points = node.attribute("points").value();
  std::vector<double> coordinates;
  for (NumberCursor cursor(points); const auto value = cursor.number();) coordinates.push_back(*value);
  return svg_polyline(coordinates, name == "polygon");
}

std::optional<Colour> fill_of(const Style& style, double opacity, Refusal& refusal) {
  return paint_of(style, Property::fill, Property::fill_opacity, opacity, refusal);
}

std::optional<Stroke> stroke_of(const Style& style, double opacity, const Eigen::Affine2d& to_pattern,
                                const Vector2d& viewport, Refusal& refusal) {
  const auto colour = paint_of(style, Property::stroke, Property::stroke_opacity, opacity, refusal);
  if (!colour) return std::nullopt;
  const auto width = svg_length(style[Property::stroke_width], LengthOf::diagonal, viewport);
  if (!width) refusal.because("widths of lines that cannot be read", "give them in mm");
  if (!width || !(*width > 0)) return std::nullopt;
  const Eigen::Vector2d sizes = to_pattern.linear().jacobiSvd().singularValues();
  if (sizes[1] < 1e-3 * sizes[0]) {
    refusal.because("lines squeezed a thousandfold", "turn them into outlines");
    return std::nullopt;
  }
  if (style[Property::vector_effect] == "non-scaling-stroke")
    refusal.because("lines that keep their width when scaled", "give their width itself");
  const double scale = std::sqrt(sizes[0] * sizes[1]);
  Stroke stroke;
  stroke.colour = *colour;
  stroke.width_mm = *width * scale;
  // The round tip of a pen becomes oval. A mirrored pen draws the same line.
  if (sizes[0] - sizes[1] > 1e-9 * sizes[0]) {
    stroke.pen = to_pattern.linear() / scale;
    if (stroke.pen.determinant() < 0) stroke.pen.col(1) *= -1;
  }
  const std::string_view cap = style[Property::stroke_linecap], join = style[Property::stroke_linejoin];
  stroke.cap = cap == "round" ? LineCap::round : cap == "square" ? LineCap::square : LineCap::butt;
  stroke.join = join == "round" ? LineJoin::round : join == "bevel" ? LineJoin::bevel : LineJoin::miter;
  if (const auto limit = svg_numbers(style[Property::stroke_miterlimit]); limit && limit->size() == 1)
    stroke.miter_limit = limit->front();
  read_dashes(style, scale, viewport, stroke, refusal);
  return stroke;
}

}  // namespace vacuform
