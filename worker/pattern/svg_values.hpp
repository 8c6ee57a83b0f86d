// Values of SVG attributes and of style properties: numbers, lengths, colours, transforms. Internal to worker/pattern.
//
// Every reader parses the whole text and returns nothing if the text does not have the expected form; none throws.
// Numbers are finite.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string_view>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Walks over a text of numbers that are separated by white space and commas, as in path data.
class NumberCursor {
 public:
  explicit NumberCursor(std::string_view text) : text_(text) {}

  std::optional<double> number();  // skips the separator before it
  std::optional<bool> flag();      // of an arc: one digit, which the next number may follow at once
  char letter();                   // the next letter, or 0
  bool at_end();
  std::string_view rest() const { return text_; }

 private:
  void skip();
  std::string_view text_;
};

// What a percentage is taken of.
enum class LengthOf { width, height, diagonal };

// In user units: px, any absolute unit at 96 px an inch, or a percentage of `viewport`. Nothing for units relative to a
// font.
std::optional<double> svg_length(std::string_view text, LengthOf of, const Eigen::Vector2d& viewport);
// A number or a percentage, clamped to [0, 1].
std::optional<double> svg_opacity(std::string_view text);
// The names of CSS, #rgb, #rgba, #rrggbb, #rrggbbaa, rgb(), rgba(), hsl(), hsla().
std::optional<Colour> svg_colour(std::string_view text);
std::optional<std::vector<double>> svg_numbers(std::string_view text);
// A list of matrix, translate, scale, rotate, skewX and skewY.
std::optional<Eigen::Affine2d> svg_transform(std::string_view text);
// From the box of a viewBox (x, y, width, height) to a viewport of `size` at the origin.
std::optional<Eigen::Affine2d> svg_view(const std::vector<double>& box, std::string_view aspect_ratio,
                                        const Eigen::Vector2d& size);

}  // namespace vacuform
