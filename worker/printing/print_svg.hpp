// print.svg: the print at 1:1 (docs/reference/files.md). Internal to worker/printing.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "worker/printing/marks.hpp"
#include "worker/printing/row_source.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// The page of a layer, for any file format.
struct PrintPage {
  Eigen::Vector2d size_mm{0, 0};  // of the sheet
  bool mirrored = false;
  PrintLabel label;  // as printable() gives it
  const Marks& marks;
};

// A picture on the page, before any mirroring.
struct PlacedPicture {
  double left_mm = 0, top_mm = 0, width_mm = 0, height_mm = 0;  // from the sheet's centre, y down
  std::span<const std::uint8_t> png;
};
PlacedPicture placed_on_page(const PixelBox& box, const PrintGrid& grid, std::span<const std::uint8_t> png);

// The ink of the page: vectors, or otherwise a picture.
struct PageContent {
  const VectorPrint* vectors = nullptr;
  std::optional<PlacedPicture> picture = {};
  std::span<const std::uint8_t> opacity = {};  // of a picture of RGB, as a gray PNG; empty: opaque, or RGBA
};

// Layer "pattern" holds the vectors, each element in a group with its id, or otherwise the picture, under scale(-1 1)
// if mirrored; layer "marks" holds the marks as vectors and text. If an element has the id of a layer, the layer is
// called "pattern-layer" or "marks-layer". Coordinates to 1e-4 mm.
std::string make_svg(const PrintPage& page, const PageContent& content);

}  // namespace vacuform
