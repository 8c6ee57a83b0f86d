// Sorts what is painted into elements: each coil with its marks, figures of their own, and ink in no element.
//
// A *coil* is a conductor that is closed or nearly (drawn_loop.hpp), wherever it stands in the file, but on one face; ids and
// groups name it. What is on layers of other steps of printing is no coil. Loops that cross or lie in each other are coils of their own. A loop of less than 4 mm radius within or on a coil
// four times as large, and one that lies on the trace of another, is a mark.
//
// A *mark* is a piece that belongs to a coil: it touches the coil or lies in it and reaches little farther, or a group
// holds it and no other coil. A line that joins two coils is in no element. Of a drawing with several layers these are no
// groups: what is drawn at one place belongs together on all of them, and is printed in register.
//
// A *figure* is other ink that holds together: a group of at most 40 mm across that holds no coil, or else pieces near
// each other, at most 150 mm across. What is larger is in no element. With more than 256 coils and figures, the figures are in none;
// with more than 1024 coils, nothing is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// A group of the file, or a shape with an id.
struct FileNode {
  std::string id;   // may be empty
  int parent = -1;  // index; -1: none
  bool shape = false;
  std::optional<CoilPlace> place = {};
  bool layer = false;  // named after a step of printing
};

// A shape as it was painted. Its curves are one piece: those of several are split by pieces_of() (pieces.hpp).
struct PaintedShape {
  Shape shape;
  int node = -1;  // that holds it, or that it is
};

// An element without its shapes, and the pieces that it consists of, ascending.
struct SortedElement {
  std::string id;
  Eigen::Vector2d centre{0, 0};
  std::optional<DrawnLoop> loop;
  std::vector<int> pieces;
  int leading = 0;  // of the pieces: the first of its loop
  std::optional<CoilPlace> place = {};
};

// Elements by their leading pieces. Ids are those of the file, numbered where they are equal ("-2"), or "coil-1", "mark-1",
// where the file has none. Deterministic; O(n log n) for n points of curves.
std::vector<SortedElement> sort_into_elements(const std::vector<PaintedShape>& pieces,
                                              const std::vector<FileNode>& nodes);

// The elements with their shapes, and what is in no element between them, in the order of painting.
std::vector<Element> with_shapes(std::vector<SortedElement> sorted, std::vector<PaintedShape> pieces);

// Shapes that are one element whatever they show, with the largest loop among them.
Element one_element(std::string id, std::vector<Shape> shapes);

}  // namespace vacuform
