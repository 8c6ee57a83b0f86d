// The elements of a picture: the connected parts of its ink.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// On a grid of about a million points over the drawing, at least 0.1 mm apart. Points of half coverage and more that
// touch, also by a corner, are one part; parts of less than 1 mm2 are specks and none. Deterministic, O(points).
class InkParts {
 public:
  explicit InkParts(const Pattern& pattern);

  // One element a part, by rows from the top: "ink-1", "ink-2", ..., its centroid as the centre, and the outlines of its ink
  // at half coverage as one filled shape.
  const Drawing& drawing() const { return drawing_; }

  // The element that ink at `uv` belongs to: the nearest within about a millimetre, so that smoothed edges go with their
  // part; -1 beyond.
  int part_at(const Eigen::Vector2d& uv) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  Eigen::Vector2d uv(double x, double y) const;  // of a point of the grid
  std::vector<float> coverage(const Pattern& pattern) const;
  void label(const std::vector<float>& ink);
  void outline(const std::vector<float>& ink);
  void spread();

  Drawing drawing_;
  double step_ = 0.1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::int32_t> labels_;  // element of each point of the grid; -1: none
};

// The parts of a picture where they are to be placed one by one: always with pattern.placement elements; with auto where
// there are 2 to 128 and none is more than 150 mm across, as the coils of an array are that do not touch.
std::optional<InkParts> parts_to_place(const Pattern& pattern, PatternPlacement placement);

}  // namespace vacuform
