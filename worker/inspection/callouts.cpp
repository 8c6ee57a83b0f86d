#include "worker/inspection/callouts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "worker/inspection/canvas.hpp"
#include "worker/inspection/caption.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;

enum class Symbol { disk, square, diamond, triangle, arrow, pentagon, hexagon, house, bar, octagon };

struct Look {
  std::string_view code;
  std::string_view words;
  Symbol shape;
  std::array<int, 3> colour;
  bool dark_number;
  bool extent = true;    // its size lies along the sheet, and a ring shows it
  std::size_t most = 6;  // marks that are drawn
};
constexpr std::array<Look, 13> looks{{
    {"undercut", "undercuts", Symbol::arrow, {213, 94, 0}, false},
    {"trapped-air", "vents to drill", Symbol::disk, {86, 180, 233}, true, false, 20},
    {"not-reached", "not reached", Symbol::square, {0, 114, 178}, false},
    {"webbing", "webs and folds", Symbol::diamond, {230, 159, 0}, true},
    {"thin", "thin places", Symbol::triangle, {204, 121, 167}, true},
    {"window-close", "window close", Symbol::pentagon, {0, 158, 115}, false, false},
    {"deep-draw", "deep draw", Symbol::hexagon, {240, 228, 66}, true, false},
    {"clamp-narrow", "narrow clamp", Symbol::house, {255, 255, 255}, true, false},
    {"too-cold", "too cold", Symbol::bar, {20, 50, 120}, false},
    {"too-hot", "too hot", Symbol::octagon, {150, 15, 35}, false},
    {"trace-stretched", "stretched traces", Symbol::hexagon, {0, 0, 0}, false},
    {"coils-coupled", "coupled coils", Symbol::bar, {90, 60, 140}, false},
    {"", "", Symbol::house, {60, 60, 60}, false},  // any other code
}};
int look_of(const Warning& warning) {
  const auto it =
      std::find_if(looks.begin(), looks.end() - 1, [&](const Look& l) { return l.code == warning.code; });
  return static_cast<int>(it - looks.begin());
}

Rgb colour_of(const Look& look) {
  return Rgb(static_cast<float>(look.colour[0]), static_cast<float>(look.colour[1]),
             static_cast<float>(look.colour[2])) /
         255;
}
const Rgb symbol_ink(0.08f, 0.09f, 0.11f), symbol_paper(1, 1, 1);

constexpr double badge = 23;     // radius, pixels: its number can be read at the width of a phone
constexpr int legend_row = 70;   // of the legend
constexpr double hidden_mm = 3;  // behind the sheet; a mark nearer to it counts as on it
constexpr double least_ring = 9, most_ring = 90;

// The outline of a badge about the origin, of about the area of a disk of radius 1.
std::vector<Vector2d> corners(Symbol shape) {
  const auto regular = [](int n, double radius, double from_deg) {
    std::vector<Vector2d> points;
    for (int i = 0; i < n; ++i) {
      const double a = (from_deg + 360.0 * i / n) * M_PI / 180;
      points.emplace_back(radius * std::cos(a), radius * std::sin(a));
    }
    return points;
  };
  switch (shape) {
    case Symbol::disk:
      return regular(48, 1, 0);
    case Symbol::square:
      return regular(4, 1.27, 45);
    case Symbol::diamond:
      return regular(4, 1.34, 0);
    case Symbol::triangle:
      return regular(3, 1.55, -90);
    case Symbol::arrow:
      return regular(3, 1.55, 90);
    case Symbol::pentagon:
      return regular(5, 1.18, -90);
    case Symbol::hexagon:
      return regular(6, 1.12, 0);
    case Symbol::house:
      return {{-0.9, 1}, {-0.9, -0.4}, {0, -1.25}, {0.9, -0.4}, {0.9, 1}};
    case Symbol::bar:
      return {{-1.2, 0.72}, {-1.2, -0.72}, {1.2, -0.72}, {1.2, 0.72}};
    case Symbol::octagon:
      return regular(8, 1.08, 22.5);
  }
  return {};
}

void draw_badge(Canvas& canvas, const Look& look, const Vector2d& at, const std::string& number) {
  cairo_t* cairo = canvas.cairo();
  cairo_new_path(cairo);
  for (const Vector2d& corner : corners(look.shape))
    cairo_line_to(cairo, at.x() + badge * corner.x(), at.y() + badge * corner.y());
  cairo_close_path(cairo);
  canvas.colour(colour_of(look));
  cairo_fill_preserve(cairo);
  canvas.colour(symbol_ink);
  cairo_set_line_width(cairo, 2.5);
  cairo_stroke(cairo);
  // Triangles and arrows have their space below or above the middle.
  const double shift = look.shape == Symbol::triangle ? 5 : look.shape == Symbol::arrow ? -4 : 0;
  canvas.text(number, at.x(), at.y() + 10 + shift, 28, true, 0.5,
              look.dark_number ? symbol_ink : symbol_paper);
}

// A line or ring that stands out from light and dark: dark between two bright edges.
void stroke(Canvas& canvas, const Look& look, bool dashed) {
  cairo_t* cairo = canvas.cairo();
  constexpr double dash[] = {9, 7};
  cairo_set_dash(cairo, dash, dashed ? 2 : 0, 0);
  cairo_set_line_width(cairo, 7);
  canvas.colour(symbol_ink);
  cairo_stroke_preserve(cairo);
  cairo_set_line_width(cairo, 3.5);
  canvas.colour(colour_of(look));
  cairo_stroke(cairo);
  cairo_set_dash(cairo, nullptr, 0, 0);
}

struct Callout {
  const Look* look;
  int number;
  Vector2d place;  // of the mark, kept inside the picture
  double ring;     // radius, pixels
  bool dashed;
  Vector2d badge_at;
};

// Puts each badge beside its ring, at the best of 16 directions and six distances: near the ring, inside the picture
// and clear of other rings and badges.
void place_badges(std::vector<Callout>& callouts, const Vector2d& low, const Vector2d& high) {
  for (std::size_t i = 0; i < callouts.size(); ++i) {
    Callout& c = callouts[i];
    double best_cost = HUGE_VAL;
    for (int distance = 0; distance < 6; ++distance)
      for (int k = 0; k < 16; ++k) {
        const double a = -M_PI / 4 + 2 * M_PI * k / 16, reach = c.ring + badge + 10 + 26 * distance;
        const Vector2d at = c.place + reach * Vector2d(std::cos(a), std::sin(a));
        double cost = 0.4 * reach;
        const Vector2d out = (low - at).cwiseMax(at - high).array() + 1.3 * badge;
        cost += 50 * std::max(0.0, out.maxCoeff());
        for (std::size_t j = 0; j < callouts.size(); ++j) {
          if (j < i) cost += 8 * std::max(0.0, 2.6 * badge - (callouts[j].badge_at - at).norm());
          const double bare = callouts[j].ring + 1.2 * badge;
          cost += 2 * std::max(0.0, bare - (callouts[j].place - at).norm());
        }
        if (cost < best_cost) best_cost = cost, c.badge_at = at;
      }
  }
}

void draw_legend(Canvas& canvas, const std::vector<const Warning*>& marked, double top, double width) {
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const Warning& warning = *marked[i];
    const Look& look = looks[look_of(warning)];
    const std::size_t line = i / 2;
    const double x = 62 + (i % 2 == 0 ? 0 : width / 2 - 10),
                 y = top + 52 + legend_row * static_cast<double>(line);
    const std::size_t count = warning.marks.size();
    draw_badge(canvas, look, {x, y}, std::to_string(count));
    std::string words(look.words.empty() ? std::string_view(warning.code) : look.words);
    std::replace(words.begin(), words.end(), '-', ' ');
    if (count > look.most) words += ", " + std::to_string(look.most) + " shown";
    canvas.text(words, x + 42, y + 10, 27, false, 0, 0.13f, width / 2 - 110);
  }
}

}  // namespace

Callouts::Callouts(const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings) {
    const int look = look_of(warning);
    const std::size_t most = looks[look].most;
    for (std::size_t i = 0; i < std::min(warning.marks.size(), most); ++i) {
      const auto& [place, size_mm] = warning.marks[i];
      marks_.push_back({look, static_cast<int>(i) + 1, {place[0], place[1], place[2]}, size_mm});
    }
  }
}

template <class Takes>
Callouts Callouts::take(const View& view, Takes&& takes) {
  Callouts taken;
  std::vector<Mark> left;
  for (Mark mark : marks_) {
    const auto spot = view.spot(mark.place);
    const double before = std::exchange(mark.behind_mm, spot ? spot->behind_mm : HUGE_VAL);
    (takes(before, mark.behind_mm) ? taken.marks_ : left).push_back(mark);
  }
  marks_ = std::move(left);
  return taken;
}

Callouts Callouts::take_hidden(const View& view) {
  return take(view, [](double, double behind) { return behind > hidden_mm; });
}

Callouts Callouts::take_no_better(const View& view) {
  return take(view, [](double before, double behind) { return behind >= before; });
}

void Callouts::add(const Callouts& others) {
  marks_.insert(marks_.end(), others.marks_.begin(), others.marks_.end());
}

void Callouts::draw(const View& view, Picture& picture, int top, int bottom) const {
  constexpr double margin = 14;
  const Vector2d low(margin, top + margin), high(picture.width - margin, bottom - margin);
  std::vector<Callout> callouts;
  for (const Mark& mark : marks_) {
    const auto spot = view.spot(mark.place);
    if (!spot) continue;
    const Look& look = looks[mark.look];
    const Vector2d place = Vector2d(spot->x, spot->y).cwiseMax(low).cwiseMin(high);
    const double ring = look.extent ? mark.size_mm / 2 * spot->pixels_per_mm : 0;
    callouts.push_back({&look, mark.number, place, std::clamp(ring, least_ring, most_ring),
                        spot->behind_mm > hidden_mm, place});
  }
  place_badges(callouts, low, high);

  Canvas canvas(picture);
  cairo_t* cairo = canvas.cairo();
  cairo_rectangle(cairo, 0, top, picture.width, bottom - top);
  cairo_clip(cairo);
  for (const Callout& c : callouts) {
    const Vector2d way = (c.badge_at - c.place).normalized();
    const Vector2d from = c.place + c.ring * way;
    cairo_move_to(cairo, from.x(), from.y());
    cairo_line_to(cairo, c.badge_at.x(), c.badge_at.y());
    stroke(canvas, *c.look, false);
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, c.place.x(), c.place.y(), c.ring, 0, 2 * M_PI);
    stroke(canvas, *c.look, c.dashed);
  }
  for (const Callout& c : callouts) draw_badge(canvas, *c.look, c.badge_at, std::to_string(c.number));
}

void write_findings(const std::vector<Warning>& warnings, Picture& picture, const Picture* behind) {
  std::vector<const Warning*> marked;
  for (const Warning& warning : warnings)
    if (!warning.marks.empty()) marked.push_back(&warning);
  const int front = picture.height - caption_bottom, shown = front + (behind ? behind->height : 0);
  const std::size_t columns = static_cast<std::size_t>(picture.width);
  picture.height =
      shown + std::max(caption_bottom, 44 + legend_row * static_cast<int>((marked.size() + 1) / 2));
  picture.pixels.resize(columns * static_cast<std::size_t>(picture.height));
  if (behind)
    std::copy(behind->pixels.begin(), behind->pixels.end(),
              picture.pixels.begin() + static_cast<std::ptrdiff_t>(columns) * front);

  Canvas canvas(picture);
  canvas.band(0, caption_top, caption_top - 1);
  canvas.text("What to look at before forming", 40, 50, 27, true, 0, 0.13f);
  canvas.text("the worst is 1; a ring is as large as its place, dashed where it is hidden", 40, 84, 21, false,
              0, 0.32f);
  if (behind) {
    canvas.band(front, front + behind_top, front);
    canvas.text("From behind", 40, front + 38, 27, true, 0, 0.13f);
  }
  canvas.band(shown, picture.height, shown);
  if (marked.empty())
    canvas.text("Nothing found that has a place on the part.", 40, picture.height - 38, 27, false, 0, 0.2f);
  draw_legend(canvas, marked, shown, picture.width);
}

}  // namespace vacuform
