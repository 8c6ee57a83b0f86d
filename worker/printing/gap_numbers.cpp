#include "worker/printing/gap_numbers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <string>

namespace vacuform {

namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr double letters_mm = 1.8;
constexpr double digit_em = 0.64, height_em = 0.73;  // of DejaVu Sans
constexpr double clear_mm = 0.4;

// The first free box beside the place: on the side to try first before the other, near before far.
std::optional<Box> free_box(const PlaceNumber& place, const Vector2d& half, const LaidInk& ink,
                            const std::vector<Box>& taken) {
  constexpr double nearest_mm = 1.5, farthest_mm = 9, step_mm = 0.25;
  const Vector2d along(-place.towards.y(), place.towards.x());
  for (double far = nearest_mm; far <= farthest_mm; far += step_mm)
    for (const double side : {1.0, -1.0})
      for (const double shift : {0.0, 1.0, -1.0, 2.0, -2.0}) {
        const Vector2d middle = place.at + side * far * place.towards + shift * along;
        const Box box(middle - half, middle + half);
        if (!ink.any_in(box) &&
            std::none_of(taken.begin(), taken.end(), [&](const Box& other) { return other.intersects(box); }))
          return box;
      }
  return std::nullopt;
}

}  // namespace

std::vector<Text> place_numbers(const std::vector<PlaceNumber>& numbers, const LaidInk& ink, bool mirrored) {
  std::vector<Text> out;
  std::vector<Box> taken;
  for (const PlaceNumber& place : numbers) {
    std::string text = std::to_string(place.number);
    const Vector2d half = Vector2d(digit_em * static_cast<double>(text.size()), height_em) * letters_mm / 2 +
                          Vector2d::Constant(clear_mm);
    const auto box = free_box(place, half, ink, taken);
    if (!box) continue;
    taken.push_back(*box);
    const Vector2d at = box->center() - Vector2d(0, height_em * letters_mm / 2);
    out.push_back({.at = {mirrored ? -at.x() : at.x(), at.y()},
                   .size = letters_mm,
                   .centred = true,
                   .text = std::move(text)});
  }
  return out;
}

}  // namespace vacuform
