#include "worker/inspection/side_marks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/inspection/canvas.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;
constexpr double letter_size = 24;  // pixels

}  // namespace

void write_letter(Canvas& canvas, const std::string& letter, double x, double y) {
  cairo_t* cairo = canvas.cairo();
  constexpr double halo = 4;
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_BOLD);
  cairo_set_font_size(cairo, letter_size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, letter.c_str(), &extents);
  cairo_new_path(cairo);
  cairo_move_to(cairo, x - extents.x_advance / 2, y - extents.y_bearing / 2);
  cairo_text_path(cairo, letter.c_str());
  cairo_set_line_width(cairo, halo);
  cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
  canvas.colour({1, 1, 1});
  cairo_stroke_preserve(cairo);
  canvas.colour({0.04f, 0.24f, 0.52f});
  cairo_fill(cairo);
}

namespace {

std::string named(const std::string& letter, const char* axis) {
  const std::string in_brackets = " (" + letter + ")";
  if (letter == "L") return "Patient's left" + in_brackets;
  if (letter == "R") return "Patient's right" + in_brackets;
  return axis + in_brackets;
}

}  // namespace

std::string side_words(View::Side side, const SideLetters& letters) {
  switch (side) {
    case View::Side::front:
    case View::Side::straight_front:
      return "Front (" + letters.plus_y + ")";
    case View::Side::behind:
    case View::Side::straight_back:
      return "Back (" + letters.minus_y + ")";
    case View::Side::minus_x:
      return named(letters.minus_x, "Side at -x");
    case View::Side::plus_x:
      return named(letters.plus_x, "Side at +x");
    case View::Side::above:
      break;
  }
  return "Above, front at the top";
}

void write_sides(const View& view, const SideLetters& letters, Picture& picture, int top, int bottom) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : view.shown()) box.extend(p);
  const Vector3d middle = box.center(), half = box.sizes() / 2;
  const double away = 0.12 * half.head<2>().maxCoeff(), low = box.min().z() + away;
  const struct {
    const std::string& letter;
    Vector3d towards, place;
  } signs[] = {{letters.minus_x, {-1, 0, 0}, {box.min().x() - away, middle.y(), low}},
               {letters.plus_x, {1, 0, 0}, {box.max().x() + away, middle.y(), low}},
               {letters.minus_y, {0, -1, 0}, {middle.x(), box.min().y() - away, low}},
               {letters.plus_y, {0, 1, 0}, {middle.x(), box.max().y() + away, low}},
               {letters.plus_z, {0, 0, 1}, {middle.x(), middle.y(), box.max().z() + 1.5 * away}}};
  constexpr double straight = 0.98, steep = 0.7, hidden_mm = 1;
  const double side = 0.8 * letter_size;
  Canvas canvas(picture);
  for (const auto& sign : signs) {
    if (sign.towards.dot(view.towards_eye()) > (sign.towards.z() > 0 ? steep : straight)) continue;
    const auto spot = view.spot(sign.place);
    if (!spot || spot->behind_mm > hidden_mm) continue;
    write_letter(canvas, sign.letter, std::clamp(spot->x, side, picture.width - side),
                 std::clamp(spot->y, top + side, bottom - side));
  }
}

}  // namespace vacuform
