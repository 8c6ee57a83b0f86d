// The user's drawing as vectors: what is painted, in pattern coordinates, sorted into elements (sorting.hpp).
//
// An *element* is one coil with its marks, or one figure that keeps its shape. What is in no element, such as a line
// that joins coils, is painted too.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/print_step.hpp"
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
  double ink() const { return a * (1 - (0.2126 * r + 0.7152 * g + 0.0722 * b)); }  // coverage (pattern.hpp)
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
  std::optional<DrawnLayer> layer =
      {};  // of the drawing, if it is named after a step of printing; without openings
};

// The loop of a coil: the middle of its trace, closed across its gaps.
struct DrawnLoop {
  std::vector<Eigen::Vector2d> line;  // closed, pattern coordinates; the first point is not repeated
  double width_mm = 0;                // of the trace
  double area_mm2 = 0;                // enclosed; of a line that crosses itself that of all its lobes
  bool filled = false;                // drawn by its outlines and not as a line
};

// Where a layout (worker/coils/array_layout.hpp) put a coil on the surface that it was made for.
struct CoilPlace {
  Eigen::Vector3d at{0, 0, 0},
      u{1, 0, 0};               // of its centre on the inked surface, mm; the direction of u there
  Eigen::Vector2d drawn{0, 0};  // its centre in the drawing then, pattern coordinates
};

struct Element {
  std::string id;  // empty: not in an element
  // Middle of the box around the loop, or else around the curves, pattern coordinates; unused without an id.
  Eigen::Vector2d centre{0, 0};
  std::vector<Shape> shapes;
  std::optional<DrawnLoop> loop = {};   // of a coil
  std::optional<CoilPlace> place = {};  // of a coil, from `data-place` of its group
};

struct Drawing {
  Eigen::Vector2d size_mm{0, 0};
  std::vector<Element> elements;  // in the order of painting
  double loose_ink_mm2 = 0;       // in no element; where shapes overlap, of each
  // Of one layer of a drawing: all of it, with the same elements. Lines are tied to its ink, so that those of several layers
  // stay on each other. Null: to their own.
  std::shared_ptr<const Drawing> whole = {};

  // Whether it has layers for other steps of printing than the first, or for another face.
  bool layered() const;
  // Whether these say how its loops are parted: resist and pictures alone do not.
  bool parts_loops() const;
};

// Reads the SVG of the pattern (pattern.svg()), at the size of the pattern: basic shapes, paths, use, symbols, groups,
// inner pages, transforms, presentation attributes, style attributes and style sheets of simple selectors. Keeps what
// extends beyond the page; the printing code cuts it. Returns nothing if the drawing is not an SVG, or if it contains
// what these vectors cannot represent (text, pictures, gradients, filters, clips, masks, markers, blended groups, more
// than 200,000 segments). `warnings` then says what, and how to fix it ("pattern-as-picture", and
// "layers-as-one" if it has layers for several steps of printing). A <use> without an id has the id of its target. A group is
// a layer if its inkscape:label, or else its id, is one of drawn_layer() (print_step.hpp); the innermost counts. In a drawing
// whose ink is all on layers of resist and pictures, these names say nothing: it is printed as one without layers. A resist by its
// openings becomes one that covers the page, with its openings in white.
// Deterministic; takes about a second at most for any input.
std::optional<Drawing> read_drawing(const Pattern& pattern, std::vector<Warning>& warnings);
// The same of the text of an SVG whose page has that size. Its root has a viewBox, or a size in user units.
std::optional<Drawing> read_drawing(const std::string& svg, const Eigen::Vector2d& size_mm,
                                    std::vector<Warning>& warnings);

}  // namespace vacuform
