// The elements of a picture: the connected parts of its ink, sorted as the pieces of a drawing are (sorting.hpp). Where
// circular loops touch or overlap in one part, each is a piece.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/pattern/drawing.hpp"
#include "worker/pattern/ink_rings.hpp"
#include "worker/pattern/sorting.hpp"

namespace vacuform {

// On a grid of about a million points over the drawing, at least 0.1 mm apart. Points of half coverage and more that
// touch, also by a corner, form one part. Parts of less than 1 mm2 are specks and are ignored. If a part shows two or
// more rings (ink_rings.hpp), the rings are pieces. They share the ink where they cross, and ink of the part in
// no ring is in no element. Deterministic; O(points), and a tenth of a second per ring.
class InkParts {
 public:
  explicit InkParts(const Pattern& pattern);

  // Pieces by rows from the top, each the outlines of its ink at half coverage as one filled shape.
  const Drawing& drawing() const { return drawing_; }

  // Whether ink at `uv` belongs to the element, or with -1 to none. It belongs to the nearest part within about a
  // millimetre, so that smoothed edges stay with their part.
  bool holds(int element, const Eigen::Vector2d& uv) const;

  // Whether loops may touch or overlap without having been separated: a part has two holes or more, larger than its
  // ink.
  bool entangled() const { return entangled_; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  Eigen::Vector2d uv(double x, double y) const;  // of a point of the grid
  std::vector<float> coverage(const Pattern& pattern) const;
  void label(const std::vector<float>& ink);
  std::vector<Shape> outline(const std::vector<float>& ink);
  void spread();
  std::vector<PaintedShape> pieces(std::vector<Shape> parts);
  void sort(std::vector<PaintedShape> pieces);
  int part_at(const Eigen::Vector2d& uv) const;

  struct Part {
    int first = 0, count = 1;  // its pieces
  };
  Drawing drawing_;
  std::vector<Part> parts_;
  std::vector<std::optional<InkRing>> rings_;  // of the pieces
  std::vector<int> element_of_;                // of the pieces; -1: none
  bool entangled_ = false;
  double step_ = 0.1;
  int columns_ = 0, rows_ = 0;
  std::int32_t part_count_ = 0;
  std::vector<std::int32_t> labels_;  // part of each point of the grid; -1: none
};

// The parts of a picture if they are to be placed one by one: with pattern.placement elements and auto, if there are
// elements. "ink-hangs-together" warns of loops that are then laid as one.
std::optional<InkParts> parts_to_place(const Pattern& pattern, PatternPlacement placement,
                                       std::vector<Warning>& warnings);

}  // namespace vacuform
