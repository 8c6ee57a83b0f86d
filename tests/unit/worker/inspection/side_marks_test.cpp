#include "worker/inspection/side_marks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/inspection/caption.hpp"
#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/tiles.hpp"

namespace vacuform {
namespace {

using Side = View::Side;

// A dome of 60 mm, off the centre.
TriangleMesh dome() {
  TriangleMesh mesh;
  constexpr int n = 40;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = 3.0 * i - 60, y = 3.0 * j - 60;
      mesh.vertices.emplace_back(x + 7, y - 5, std::sqrt(std::max(0.0, 3600 - x * x - y * y)));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

struct Spot {
  double x, y;
};
// The middle of the pixels of the one letter in a picture of 500 x 400 from a side.
std::optional<Spot> letter_at(const SideLetters& only, Side side) {
  const TriangleMesh mesh = dome();
  View view(mesh, mesh.vertices, only, 500, 400, 0, 0);
  view.look_from(side, 500, 400, 0, 0);
  const auto pictures = view.draw(
      1, [](const Seen&, Rgb* colour) { *colour = Rgb(0.9f, 0.9f, 0.9f); }, Context(), 0, 1);
  EXPECT_TRUE(pictures);
  double x = 0, y = 0;
  int count = 0;
  for (int row = 0; row < 400; ++row)
    for (int column = 0; column < 500; ++column)
      if ((pictures->front().pixels[static_cast<std::size_t>(500 * row + column)] & 0xff0000u) < 0x300000u)
        x += column, y += row, ++count;
  if (count < 20) return std::nullopt;
  return Spot{x / count, y / count};
}

const SideLetters left{"L", "", "", "", ""}, right{"", "R", "", "", ""}, front{"", "", "A", "", ""},
    back{"", "", "", "P", ""}, head{"", "", "", "", "H"};

TEST(SideLetters, AreOnTheirSideOfEveryPicture) {
  struct Row {
    const SideLetters& letter;
    Side side;
    int right, down;  // of the middle of the picture: -1, 0 or 1; 2: not there
  };
  for (const Row& row :
       {Row{left, Side::straight_front, 1, 0}, Row{right, Side::straight_front, -1, 0},
        Row{head, Side::straight_front, 0, -1}, Row{back, Side::straight_front, 2, 2},
        Row{left, Side::straight_back, -1, 0}, Row{right, Side::straight_back, 1, 0},
        Row{front, Side::straight_back, 2, 2}, Row{front, Side::minus_x, -1, 0},
        Row{back, Side::minus_x, 1, 0}, Row{right, Side::minus_x, 2, 2}, Row{front, Side::plus_x, 1, 0},
        Row{back, Side::plus_x, -1, 0}, Row{front, Side::above, 0, -1}, Row{back, Side::above, 0, 1},
        Row{left, Side::above, -1, 0}, Row{right, Side::above, 1, 0}, Row{head, Side::above, 2, 2}}) {
    const auto spot = letter_at(row.letter, row.side);
    const std::string words = side_words(row.side, row.letter) + " of " + row.letter.minus_x +
                              row.letter.plus_x + row.letter.plus_y + row.letter.minus_y + row.letter.plus_z;
    ASSERT_EQ(spot.has_value(), row.right != 2) << words;
    if (!spot) continue;
    const auto third = [](double at, double size) { return at < size / 3 ? -1 : at > 2 * size / 3 ? 1 : 0; };
    EXPECT_EQ(third(spot->x, 500), row.right) << words << " at " << spot->x;
    if (row.right == 0) {
      EXPECT_EQ(third(spot->y, 400), row.down) << words << " at " << spot->y;
    }
  }
}

TEST(SideLetters, NameTheSideOfAPicture) {
  const SideLetters sure = side_letters(LeftSide::minus_x), turned = side_letters(LeftSide::plus_x),
                    open = side_letters(LeftSide::unknown);
  EXPECT_EQ(side_words(Side::straight_front, sure), "Front (A)");
  EXPECT_EQ(side_words(Side::straight_back, open), "Back (P?)");
  EXPECT_EQ(side_words(Side::minus_x, sure), "Patient's left (L)");
  EXPECT_EQ(side_words(Side::minus_x, turned), "Patient's right (R)");
  EXPECT_EQ(side_words(Side::plus_x, turned), "Patient's left (L)");
  EXPECT_EQ(side_words(Side::plus_x, open), "Side at +x (R?)");
  EXPECT_EQ(side_words(Side::above, sure), "Above, front at the top");
}

// No pixel of a text in the last columns of a picture.
bool clear_at_the_right(const Picture& picture, int from, int to) {
  for (int y = from; y < to; ++y)
    for (int x = picture.width - 5; x < picture.width; ++x)
      if ((picture.pixels[static_cast<std::size_t>(y * picture.width + x)] & 0xffu) < 0xa0u) return false;
  return true;
}

TEST(Captions, FitAtAnyNumber) {
  CoilTable table;
  table.coils.resize(512);
  table.with.coils = 511;
  table.with.mean_shape_error = 9.8765, table.with.worst_shape_error = 123.4567,
  table.with.mean_area_error = 45.6789;
  const std::string longest = coils_caption(table, Way::with);
  for (const std::string& figures : {longest, ink_caption(0.1234, 0.1111), colours_caption(0.4567)}) {
    Picture picture{1000, 1000, std::vector<std::uint32_t>(1'000'000, 0xffffffffu)};
    write({"The pre-distorted print, formed over a head with a very long title that nobody shortened",
           figures,
           {},
           figures},
          picture);
    EXPECT_TRUE(clear_at_the_right(picture, 0, caption_top)) << figures;
    EXPECT_TRUE(clear_at_the_right(picture, 1000 - caption_bottom, 1000)) << figures;
    Canvas canvas(picture);
    EXPECT_GE(canvas.text(figures, 40, 82, 17, false, 0, 0.3f, 920), 12) << "too small to read: " << figures;
  }
}

TEST(Captions, OfTilesStayInTheirTile) {
  Tiles tiles(2);
  tiles.put(0, {tile_width, tile_height, std::vector<std::uint32_t>(tile_width * tile_height, 0xffffffffu)},
            "Formed part: a label that is far too long for a tile of this width and goes on and on");
  const Picture whole = tiles.finished({"Title", "figures", {}, "note"});
  for (int y = caption_top; y < caption_top + tile_label; ++y)
    for (int x = tile_width - 8; x < whole.width; ++x)
      ASSERT_GT(whole.pixels[static_cast<std::size_t>(y * whole.width + x)] & 0xffu, 0xa0u) << x << " " << y;
}

}  // namespace
}  // namespace vacuform
