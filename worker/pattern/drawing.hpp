// The user's drawing as vectors: what is painted, in pattern coordinates, sorted into elements.
//
// An *element* is one coil, or one figure that keeps its shape: a group of the SVG with an id that holds no other such
// group (layers and groups of groups are looked into), or a shape with an id outside such groups. What is in no
// element, such as a line that joins coils, is painted all the same.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/pattern/pattern.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// Cubic Bezier segments that follow one another: 3 n + 1 points. Of a closed curve the last point is the first.
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

// Widened, joined, capped and dashed where `pen` is the identity, and then taken by it to the pattern: a transform that
// stretches a line more one way than the other makes it wider there too.
struct Stroke {
  Colour colour;
  double width_mm = 0;  // in the mean over its directions
  LineCap cap = LineCap::butt;
  LineJoin join = LineJoin::miter;
  double miter_limit = 4;
  std::vector<double> dashes_mm;  // none: a continuous line
  double dash_offset_mm = 0;
  Eigen::Matrix2d pen = Eigen::Matrix2d::Identity();  // of determinant 1
};

// What is painted at once, the fill before the stroke. At least one of the two is there.
struct Shape {
  std::vector<Curve> curves;  // pattern coordinates (u, v): mm from the drawing's centre, v up
  std::optional<Colour> fill;
  bool even_odd = false;
  std::optional<Stroke> stroke;
};

struct Element {
  std::string id;  // empty: what belongs to no element
  Eigen::Vector2d centre{
      0, 0};  // middle of the box around the curves, pattern coordinates; unused without an id
  std::vector<Shape> shapes;
};

struct Drawing {
  Eigen::Vector2d size_mm{0, 0};
  std::vector<Element> elements;  // in the order of painting
};

// Reads the SVG that `pattern` was read from, to the pattern's size: basic shapes, paths, use, symbols, groups, inner
// pages, transforms, presentation attributes, style attributes and style sheets of simple selectors. What sticks out of the
// page is kept here and cut by who prints. A drawing that is no SVG gives nothing; so does one that holds what these
// vectors cannot (text, pictures, gradients, filters, clips, masks, markers, blended groups, more than 200,000 segments), and
// `warnings` then says what, and how to fix it ("pattern-as-picture"). An element has ink: white shapes alone are none. Of equal ids the later ones get "-2", "-3",
// ...; a <use> without an id has its target's. Deterministic; within a second or so whatever the bytes.
std::optional<Drawing> read_drawing(std::span<const std::uint8_t> bytes, const Pattern& pattern,
                                    std::vector<Warning>& warnings);

}  // namespace vacuform
