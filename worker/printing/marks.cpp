#include "worker/printing/marks.hpp"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>

#include "api/base/decimal.hpp"
#include "api/base/markup.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
constexpr double line_mm = 0.15;
constexpr double dash_mm = 1.5;
constexpr double letter_mm = 2.4;
constexpr char font[] = "DejaVu Sans";

struct Release {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, Release>;
using Cairo = std::unique_ptr<cairo_t, Release>;

void use_font(cairo_t* cairo, double size) {
  cairo_select_font_face(cairo, font, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, size);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo, options);
  cairo_font_options_destroy(options);
}

double text_width(const std::string& text, double size) {
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
  const Cairo cairo(cairo_create(surface.get()));
  // Measured large: widths are then free of rounding.
  use_font(cairo.get(), 100);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo.get(), text.c_str(), &extents);
  return extents.x_advance * size / 100;
}

std::string upper_case(std::string_view word) {
  std::string out(word);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

// Joins parts into lines no wider than `room`; a part that is wider is a line of its own.
std::vector<std::string> wrapped(const std::vector<std::string>& parts, double room) {
  std::vector<std::string> lines;
  for (const auto& part : parts) {
    const std::string longer = lines.empty() ? part : lines.back() + "   ·   " + part;
    if (!lines.empty() && text_width(longer, letter_mm) <= room)
      lines.back() = longer;
    else
      lines.push_back(part);
  }
  return lines;
}

Line segment(const Vector2d& a, const Vector2d& b) { return {.points = {a, b}}; }

Line rectangle(const Vector2d& half, bool dashed) {
  return {
      .points = {{-half.x(), -half.y()}, {half.x(), -half.y()}, {half.x(), half.y()}, {-half.x(), half.y()}},
      .closed = true,
      .filled = false,
      .dashed = dashed};
}

// A cross in a circle. The one at the lower left has two filled quadrants, so that a turned print can be recognised.
Mark registration(const std::string& name, const Vector2d& c, bool filled) {
  Mark mark{.name = name, .lines = {}, .circles = {{.centre = c, .radius = 2}}, .texts = {}};
  mark.lines = {segment(c - Vector2d(3, 0), c + Vector2d(3, 0)),
                segment(c - Vector2d(0, 3), c + Vector2d(0, 3))};
  if (filled)
    for (const double start : {0.0, M_PI}) {
      Line quadrant{.points = {c}, .closed = true, .filled = true};
      for (int i = 0; i <= 12; ++i) {
        const double angle = start + M_PI / 2 * i / 12;
        quadrant.points.push_back(c + 2 * Vector2d(std::cos(angle), std::sin(angle)));
      }
      mark.lines.push_back(quadrant);
    }
  return mark;
}

Mark ruler(double length, double top) {
  Mark mark{.name = "ruler", .lines = {}, .circles = {}, .texts = {}};
  const double left = -length / 2;
  mark.lines.push_back(segment({left, top}, {left + length, top}));
  for (int mm = 0; mm <= static_cast<int>(length); ++mm) {
    const double tick = mm % 10 == 0 ? 2.4 : mm % 5 == 0 ? 1.6 : 1.0;
    mark.lines.push_back(segment({left + mm, top}, {left + mm, top - tick}));
    if (mm % 10 == 0)
      mark.texts.push_back(
          {.at = {left + mm, top - 4.5}, .size = 2, .centred = true, .text = std::to_string(mm)});
  }
  mark.texts.push_back({.at = {left + length + 3.2, top - 4.5}, .size = 2, .text = "mm"});
  return mark;
}

Mark t_arrow(double x) {
  Mark mark{.name = "t-axis", .lines = {segment({x, -10}, {x, 8})}, .circles = {}, .texts = {}};
  mark.lines.push_back({.points = {{x, 11}, {x - 1.2, 7.5}, {x + 1.2, 7.5}}, .closed = true, .filled = true});
  mark.texts.push_back(
      {.at = {x + 2.9, 0}, .size = letter_mm, .centred = true, .upwards = true, .text = "+t, extrusion"});
  return mark;
}

// The letters of the patient's sides along the edges; +t is up, and +s to the right unless the print is mirrored.
std::vector<Mark> sides(const SideLetters& letters, bool mirrored, const Vector2d& half, double ruler_mm,
                        std::size_t legend_lines) {
  if (letters.plus_y.empty()) return {};
  constexpr double size = 4;
  const auto mark = [&](const char* name, const Vector2d& at, const std::string& letter) {
    return Mark{.name = name,
                .lines = {},
                .circles = {},
                .texts = {{.at = at, .size = size, .centred = true, .text = letter}}};
  };
  const double above_legend = -half.y() + 2 + 3.2 * static_cast<double>(legend_lines);
  return {mark("side-front", {-ruler_mm / 2 - 5, half.y() - 5.5}, letters.plus_y),
          mark("side-back", {0, above_legend}, letters.minus_y),
          mark("side-on-the-left", {-half.x() + 4, 15}, mirrored ? letters.plus_x : letters.minus_x),
          mark("side-on-the-right", {half.x() - 4, 15}, mirrored ? letters.minus_x : letters.plus_x)};
}

Eigen::AlignedBox2d box_of(const Mark& mark) {
  Eigen::AlignedBox2d box;
  for (const auto& line : mark.lines)
    for (const auto& p : line.points) box.extend(p);
  for (const auto& circle : mark.circles) {
    box.extend(circle.centre - Vector2d::Constant(circle.radius));
    box.extend(circle.centre + Vector2d::Constant(circle.radius));
  }
  for (const auto& text : mark.texts) {
    const double width = text_width(text.text, text.size), back = text.centred ? width / 2 : 0;
    const Vector2d along = text.upwards ? Vector2d(0, 1) : Vector2d(1, 0), up(-along.y(), along.x());
    for (const double a : {-back, width - back})
      for (const double b : {-0.25 * text.size, text.size}) box.extend(text.at + a * along + b * up);
  }
  return box;
}

void draw(cairo_t* cairo, const Mark& mark) {
  const double dashes[] = {dash_mm, dash_mm};
  for (const auto& line : mark.lines) {
    for (const auto& p : line.points) cairo_line_to(cairo, p.x(), p.y());
    if (line.closed) cairo_close_path(cairo);
    cairo_set_dash(cairo, dashes, line.dashed ? 2 : 0, 0);
    line.filled ? cairo_fill(cairo) : cairo_stroke(cairo);
  }
  for (const auto& circle : mark.circles) {
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, circle.centre.x(), circle.centre.y(), circle.radius, 0, 2 * M_PI);
    cairo_set_dash(cairo, dashes, circle.dashed ? 2 : 0, 0);
    cairo_stroke(cairo);
  }
  for (const auto& text : mark.texts) {
    cairo_save(cairo);
    cairo_translate(cairo, text.at.x(), text.at.y());
    if (text.upwards) cairo_rotate(cairo, M_PI / 2);
    cairo_scale(cairo, 1, -1);
    use_font(cairo, text.size);
    cairo_move_to(cairo, text.centred ? -text_width(text.text, text.size) / 2 : 0, 0);
    // Outlines and not glyph images: they are placed exactly, whatever the band they are drawn in.
    cairo_text_path(cairo, text.text.c_str());
    cairo_fill(cairo);
    cairo_restore(cairo);
  }
}

Mark window_mark(const MachineSettings& machine) {
  const bool circular = machine.window == WindowShape::circle;
  const Vector2d opening(machine.window_width_mm / 2,
                         (circular ? machine.window_width_mm : machine.window_height_mm) / 2);
  Mark window{.name = "window", .lines = {}, .circles = {}, .texts = {}};
  if (circular)
    window.circles.push_back({.centre = {0, 0}, .radius = opening.x(), .dashed = true});
  else
    window.lines.push_back(rectangle(opening, true));
  return window;
}

// What the print says about itself, in as many lines as it needs, the first at the top.
Mark legend(const Settings& settings, const MarkedPage& page, const PrintLabel& label, const Vector2d& half) {
  const SheetSettings& sheet = settings.sheet;
  const double room = 2 * half.x() - 16, margin = settings.print.margin_mm;
  const std::string side = page.mirrored ? "inner face, MIRRORED: print on the side that touches the mold"
                                         : "outer face, seen from above";
  std::vector<std::string> job{"Vacuform " + label.job, "sheet " + short_decimal(sheet.width_mm) + " × " +
                                                            short_decimal(sheet.height_mm) + " × " +
                                                            short_decimal(sheet.thickness_mm) + " mm " +
                                                            upper_case(name(sheet.material))};
  if (!label.reference.empty()) job.insert(job.begin(), "reference " + label.reference);
  if (margin > 0) job.push_back("frame " + short_decimal(margin) + " mm inside the sheet's edge");
  std::vector<std::string> print{side, "scale 1:1, check with the ruler"};
  if (!page.step.empty()) print.insert(print.begin(), page.step);
  std::vector<std::string> lines = wrapped(print, room);
  for (auto& line : wrapped(job, room)) lines.push_back(std::move(line));
  Mark out{.name = "legend", .lines = {}, .circles = {}, .texts = {}};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double width = text_width(lines[i], letter_mm);
    out.texts.push_back(
        {.at = {-half.x() + 8, -half.y() + 1.2 + 3.2 * static_cast<double>(lines.size() - 1 - i)},
         .size = letter_mm * std::min(1.0, room / width),
         .text = lines[i]});
  }
  return out;
}

double ruler_length(const Vector2d& half) {
  const double room = 2 * half.x() - 16;
  return room >= 112 ? 100 : room >= 62 ? 50 : 20;
}

// Every mark but the outline of the mold, wherever the ink lies. `half`: of the frame.
std::vector<Mark> all_marks(const Settings& settings, const MarkedPage& page, const PrintLabel& label,
                            const Vector2d& half) {
  std::vector<Mark> all;
  all.push_back({.name = settings.print.margin_mm > 0 ? "frame" : "sheet-edge",
                 .lines = {rectangle(half, false)},
                 .circles = {},
                 .texts = {}});
  Mark window = window_mark(settings.machine);
  if ((box_of(window).max().array() < half.array()).all()) all.push_back(std::move(window));
  const Vector2d corner = half - Vector2d(3.5, 3.5);
  all.push_back(registration("registration-lower-left", -corner, true));
  all.push_back(registration("registration-lower-right", {corner.x(), -corner.y()}, false));
  all.push_back(registration("registration-upper-left", {-corner.x(), corner.y()}, false));
  all.push_back(registration("registration-upper-right", corner, false));
  const double ruler_mm = ruler_length(half);
  all.push_back(ruler(ruler_mm, half.y() - 0.8));
  all.push_back(t_arrow(-half.x() + 2.2));
  Mark words = legend(settings, page, label, half);
  std::vector<Mark> letters = sides(label.sides, page.mirrored, half, ruler_mm, words.texts.size());
  all.push_back(std::move(words));
  for (Mark& letter : letters) all.push_back(std::move(letter));
  return all;
}

// The frame and the window run around the chart; they touch it only where one of their lines does.
bool touches(const Mark& mark, const std::vector<Eigen::AlignedBox2d>& taken) {
  const bool around = mark.name == "frame" || mark.name == "sheet-edge" || mark.name == "window";
  const double radius = around && !mark.circles.empty() ? mark.circles.front().radius : 0;
  std::vector<Eigen::AlignedBox2d> boxes;
  if (!around) boxes.push_back(box_of(mark));
  if (around && radius == 0) {
    const auto& corners = mark.lines.front().points;
    for (std::size_t i = 0; i < 4; ++i) {
      boxes.emplace_back(corners[i]);
      boxes.back().extend(corners[(i + 1) % 4]);
    }
  }
  return std::any_of(taken.begin(), taken.end(), [&](const Eigen::AlignedBox2d& box) {
    if (radius > 0) {
      const double far = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
      const double near = Vector2d(0, 0).cwiseMax(box.min()).cwiseMin(box.max()).norm();
      return near <= radius && radius <= far;
    }
    return std::any_of(boxes.begin(), boxes.end(), [&](const auto& b) { return b.intersects(box); });
  });
}

std::string coordinates(double x, double y) { return decimal(x, 3) + "," + decimal(y, 3); }

}  // namespace

Marks lay_out_marks(const Settings& settings, const PrintLabel& label, MarkedPage page) {
  const double margin = settings.print.margin_mm;
  const Vector2d half(settings.sheet.width_mm / 2 - margin, settings.sheet.height_mm / 2 - margin);
  Marks laid;
  if (half.minCoeff() < 20) {
    laid.warnings.push_back(
        {.code = "marks-left-out",
         .text = "print.margin_mm leaves no room for marks on this sheet; none are printed.",
         .figure = Warning::Figure{margin, "mm"},
         .place = "the sheet's edge"});
    return laid;
  }
  std::vector<std::string> left_out;
  for (Mark& mark : all_marks(settings, page, label, half)) {
    if (touches(mark, page.taken)) {
      left_out.push_back(mark.name);
      continue;
    }
    if (mark.name == "ruler") laid.ruler_mm = ruler_length(half);
    laid.marks.push_back(std::move(mark));
  }
  Mark mold{.name = "mold-outline", .lines = std::move(page.outline), .circles = {}, .texts = {}};
  if (!mold.lines.empty()) {
    const Eigen::AlignedBox2d box = box_of(mold);
    if ((box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).array() < half.array()).all())
      laid.marks.push_back(std::move(mold));
    else
      left_out.push_back(mold.name);
  }
  if (!page.numbers.empty())
    laid.marks.push_back(
        {.name = "gap-numbers", .lines = {}, .circles = {}, .texts = std::move(page.numbers)});
  if (left_out.empty()) return laid;
  std::string names;
  for (const std::string& name : left_out) names += (names.empty() ? "" : ", ") + name;
  laid.warnings.push_back({.code = "marks-left-out",
                           .text = "The pattern's region reaches the sheet's edge; the marks that would lie "
                                   "on it are not printed: " +
                                   names,
                           .figure = Warning::Figure{static_cast<double>(left_out.size()), "marks", 0.0},
                           .place = "the sheet's edge"});
  return laid;
}

std::vector<std::uint8_t> draw_marks(const Marks& marks, const PrintGrid& grid, int first_row, int rows) {
  const int width = grid.width;
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, width, rows));
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  {
    const Cairo cairo(cairo_create(surface.get()));
    cairo_translate(cairo.get(), 0.5 * width, 0.5 * grid.height - first_row);
    cairo_scale(cairo.get(), 1 / grid.pixel_mm, -1 / grid.pixel_mm);
    cairo_set_line_width(cairo.get(), std::max(line_mm, grid.pixel_mm));
    for (const auto& mark : marks.marks) draw(cairo.get(), mark);
  }
  cairo_surface_flush(surface.get());
  std::vector<std::uint8_t> coverage(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows));
  const unsigned char* data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < rows; ++y)
    std::copy_n(data + static_cast<std::ptrdiff_t>(y) * stride, width,
                coverage.data() + static_cast<std::ptrdiff_t>(y) * width);
  return coverage;
}

std::string svg_of(const Marks& marks) {
  std::string out;
  for (const auto& mark : marks.marks) {
    out += "    <g id=\"mark-" + mark.name + "\">\n";
    for (const auto& line : mark.lines) {
      std::string path;
      for (const auto& p : line.points) path += (path.empty() ? "M" : " L") + coordinates(p.x(), -p.y());
      if (line.closed) path += " Z";
      out += "      <path d=\"" + path + "\"";
      if (line.filled) out += " fill=\"#000\" stroke=\"none\"";
      if (line.dashed) out += " stroke-dasharray=\"" + short_decimal(dash_mm) + "\"";
      out += "/>\n";
    }
    for (const auto& circle : mark.circles) {
      out += "      <circle cx=\"" + decimal(circle.centre.x(), 3) + "\" cy=\"" +
             decimal(-circle.centre.y(), 3) + "\" r=\"" + decimal(circle.radius, 3) + "\"";
      if (circle.dashed) out += " stroke-dasharray=\"" + short_decimal(dash_mm) + "\"";
      out += "/>\n";
    }
    for (const auto& text : mark.texts) {
      out += "      <text transform=\"translate(" + coordinates(text.at.x(), -text.at.y()) + ")" +
             (text.upwards ? " rotate(-90)" : "") + "\" font-size=\"" + short_decimal(text.size) + "\"" +
             (text.centred ? " text-anchor=\"middle\"" : "") + " xml:space=\"preserve\">" +
             escaped(text.text) + "</text>\n";
    }
    out += "    </g>\n";
  }
  return out;
}

}  // namespace vacuform
