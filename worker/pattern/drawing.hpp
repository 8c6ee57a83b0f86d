// The user's drawing as vectors: what is painted, in pattern coordinates, sorted into elements.
//
// An *element* is one coil, or one figure that keeps its shape: a group of the SVG with an id that contains no other
// such group (the search descends into layers and groups of groups), or a shape with an id outside such groups. What is
// in no element, such as a line that joins coils, is painted too.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/pattern/pattern.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// Consecutive cubic Bezier segments: 3 n + 1 points. The last point of a closed curve equals the first.
struct Curve {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
};

// Straight colour and opacity, each in [0, 1].
struct Colour {
  double r = 0, g = 0, b = 0, a = 1;
};

enum class LineCap { butt, round, square };
enum class LineJoin { miter, round, bevel };

// Widened, joined, capped and dashed as if `pen` were the identity, then mapped to the pattern by `pen`: a transform
// that stretches a line more in one direction also makes it wider there.
struct Stroke {
  Colour colour;
  double width_mm = 0;  // averaged over its directions
  LineCap cap = LineCap::butt;
  LineJoin join = LineJoin::miter;
  double miter_limit = 4;
  std::vector<double> dashes_mm;  // empty: a continuous line
  double dash_offset_mm = 0;
  Eigen::Matrix2d pen = Eigen::Matrix2d::Identity();  // of determinant 1
};

// What is painted in one step, the fill before the stroke. At least one of the two is present.
struct Shape {
  std::vector<Curve> curves;  // pattern coordinates (u, v): mm from the drawing's centre, v up
  std::optional<Colour> fill;
  bool even_odd = false;
  std::optional<Stroke> stroke;
};

struct Element {
  std::string id;  // empty: not in an element
  Eigen::Vector2d centre{
      0, 0};  // middle of the box around the curves, pattern coordinates; unused without an id
  std::vector<Shape> shapes;
};

struct Drawing {
  Eigen::Vector2d size_mm{0, 0};
  std::vector<Element> elements;  // in the order of painting
};

// Reads the SVG that `pattern` was read from, at the size of the pattern: basic shapes, paths, use, symbols, groups,
// inner pages, transforms, presentation attributes, style attributes and style sheets of simple selectors. Keeps what
// extends beyond the page; the printing code cuts it. Returns nothing if the drawing is not an SVG, or if it contains
// what these vectors cannot represent (text, pictures, gradients, filters, clips, masks, markers, blended groups, more
// than 200,000 segments). `warnings` then says what, and how to fix it ("pattern-as-picture"). An element has ink:
// white shapes alone are not an element. If ids are equal, the later ones get "-2", "-3", ...; a <use> without an id
// has the id of its target. Deterministic; takes about a second at most for any input.
std::optional<Drawing> read_drawing(std::span<const std::uint8_t> bytes, const Pattern& pattern,
                                    std::vector<Warning>& warnings);

}  // namespace vacuform
