#include "worker/printing/gap_numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/worker/printing/painted_rows.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

template <class Holds>
LaidInk ink_where(Holds holds) {
  const PrintGrid grid = LaidInk::grid_of(80, 60);
  return {PaintedRows(grid, holds), grid};
}

// A circle of radius 20 mm with a line of 3 mm, off the middle of the sheet.
const Vector2d centre(-6, 4);
bool on_circle(const Vector2d& p) { return std::abs((p - centre).norm() - 20) < 1.5; }

// The corners and the middle of what a number covers, on the sheet.
std::vector<Vector2d> places_of(const Text& text, bool mirrored) {
  const double half = 0.64 * text.size * static_cast<double>(text.text.size()) / 2, high = 0.73 * text.size;
  const double x = mirrored ? -text.at.x() : text.at.x();
  std::vector<Vector2d> out;
  for (const double a : {-half, 0.0, half})
    for (const double b : {0.0, high / 2, high}) out.emplace_back(x + a, text.at.y() + b);
  return out;
}

TEST(GapNumbers, LieBesideTheirPlacesClearOfTheInk) {
  const LaidInk ink = ink_where(on_circle);
  for (const bool mirrored : {false, true}) {
    std::vector<PlaceNumber> numbers;
    for (int i = 0; i < 7; ++i) {
      const Vector2d out(std::cos(i * 0.9 + 0.3), std::sin(i * 0.9 + 0.3));
      numbers.push_back({i * 17 + 3, centre + 20 * out, -out});
    }
    const std::vector<Text> texts = place_numbers(numbers, ink, mirrored);
    ASSERT_EQ(texts.size(), numbers.size());
    for (std::size_t i = 0; i < texts.size(); ++i) {
      EXPECT_EQ(texts[i].text, std::to_string(numbers[i].number));
      for (const Vector2d& p : places_of(texts[i], mirrored)) {
        EXPECT_GT(std::abs((p - centre).norm() - 20), 1.6) << i;
        EXPECT_LT((p - numbers[i].at).norm(), 7) << i;
      }
    }
  }
}

TEST(GapNumbers, GoToTheOtherSideWhereInkIsInTheWay) {
  const LaidInk ink = ink_where([](const Vector2d& p) { return (p - centre).norm() < 21.5; });
  const std::vector<Text> texts = place_numbers({{12, centre + Vector2d(20, 0), {-1, 0}}}, ink, false);
  ASSERT_EQ(texts.size(), 1u);
  for (const Vector2d& p : places_of(texts[0], false)) EXPECT_GT((p - centre).norm(), 21.5);
}

TEST(GapNumbers, DoNotLieOverEachOtherAndAreLeftOutWithoutRoom) {
  const LaidInk none = ink_where([](const Vector2d&) { return false; });
  const std::vector<Text> two = place_numbers({{1, {0, 0}, {1, 0}}, {2, {0.5, 0}, {1, 0}}}, none, false);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_GT((two[0].at - two[1].at).norm(), 1.3);
  const LaidInk all = ink_where([](const Vector2d&) { return true; });
  EXPECT_TRUE(place_numbers({{1, {0, 0}, {1, 0}}}, all, false).empty());
}

}  // namespace
}  // namespace vacuform
