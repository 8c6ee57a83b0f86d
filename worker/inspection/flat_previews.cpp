#include "worker/inspection/flat_previews.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "api/base/decimal.hpp"
#include "worker/inspection/canvas.hpp"
#include "worker/inspection/caption.hpp"
#include "worker/inspection/side_marks.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
const Rgb backdrop(0.93f, 0.935f, 0.945f), paper(1, 1, 1), on_mold(0.87f, 0.93f, 0.98f),
    on_page(0.45f, 0.46f, 0.48f);  // under colours that are nearly white where all is well

// A plane of millimetres, y up, in the middle of a picture's rows between the captions.
struct Frame {
  double middle_x, middle_y, pixels_per_mm;
  Frame(const Vector2d& size_mm, int side)
      : middle_x(side / 2.0), middle_y(caption_top + (side - caption_top - caption_bottom) / 2.0) {
    const double room = side - caption_top - caption_bottom - 60;
    pixels_per_mm = std::min((side - 80) / size_mm.x(), room / size_mm.y());
  }
  Vector2d mm(double x, double y) const { return Vector2d(x - middle_x, middle_y - y) / pixels_per_mm; }
  Vector2d pixel(const Vector2d& at) const {
    return {middle_x + at.x() * pixels_per_mm, middle_y - at.y() * pixels_per_mm};
  }
};

std::uint32_t bits(const Rgb& colour) {
  const auto byte = [](float v) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
  };
  return 0xff000000u | byte(colour.x()) << 16 | byte(colour.y()) << 8 | byte(colour.z());
}

// Fills the picture with colours, 2 x 2 samples a pixel: `colours_of` gives those of a row of places, from the first
// place and the step to the next in mm.
template <class ColoursOf>
Picture painted(const Frame& frame, int side, ColoursOf&& colours_of) {
  const auto columns = static_cast<std::size_t>(side);
  Picture picture{side, side, std::vector<std::uint32_t>(columns * columns)};
  const Vector2d step(0.5 / frame.pixels_per_mm, 0);
  in_parallel(0, side, [&](int first, int last) {
    std::vector<Rgb> upper(2 * columns), lower(2 * columns);
    for (int y = first; y < last; ++y) {
      colours_of(frame.mm(0.25, y + 0.25), step, std::span(upper));
      colours_of(frame.mm(0.25, y + 0.75), step, std::span(lower));
      for (std::size_t x = 0; x < columns; ++x)
        picture.pixels[static_cast<std::size_t>(y) * columns + x] =
            bits((upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]) / 4);
    }
  });
  return picture;
}

bool outside(const Vector2d& at, const Vector2d& size) {
  return std::abs(at.x()) > size.x() / 2 || std::abs(at.y()) > size.y() / 2;
}

Rgb laid_over(const Rgb& under, const Ink& ink, bool grayscale) {
  return under + ink.a * ((grayscale ? black_ink : Rgb(ink.r, ink.g, ink.b)) - under);
}

void rectangle(Canvas& canvas, const Frame& frame, const Vector2d& half, bool dashed) {
  const Vector2d a = frame.pixel({-half.x(), half.y()}), b = frame.pixel({half.x(), -half.y()});
  constexpr double dash[] = {8, 6};
  cairo_set_dash(canvas.cairo(), dash, dashed ? 2 : 0, 0);
  cairo_rectangle(canvas.cairo(), a.x(), a.y(), b.x() - a.x(), b.y() - a.y());
  canvas.colour({0.35f, 0.38f, 0.42f});
  cairo_set_line_width(canvas.cairo(), 1.5);
  cairo_stroke(canvas.cairo());
  cairo_set_dash(canvas.cairo(), nullptr, 0, 0);
}

// A bar of a round length, at the lower right.
void scale_bar(Canvas& canvas, const Frame& frame, int side) {
  double length = 1;
  for (const double next : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0})
    if (next * frame.pixels_per_mm <= 260) length = next;
  const double right = side - 40.0, left = right - length * frame.pixels_per_mm, y = side - 30.0;
  cairo_rectangle(canvas.cairo(), left, y, right - left, 5);
  canvas.colour(black_ink);
  cairo_fill(canvas.cairo());
  canvas.text(decimal(length, 0) + " mm", (left + right) / 2, y - 9, 17, false, 0.5, 0.2f);
}

}  // namespace

Picture pattern_preview(const Finished& job, int side) {
  const Vector2d size = job.pattern.size_mm();
  const Frame frame(size, side);
  const double blur = 0.6 / frame.pixels_per_mm;
  const bool gray = job.pattern.grayscale();
  Picture picture =
      painted(frame, side, [&](const Vector2d& start, const Vector2d& step, std::span<Rgb> out) {
        std::vector<Ink> ink(out.size());
        job.pattern.sample_line(start, step, blur, ink);
        for (std::size_t k = 0; k < out.size(); ++k) {
          const Vector2d at = start + static_cast<double>(k) * step;
          out[k] = outside(at, size) ? backdrop : laid_over(paper, ink[k], gray);
        }
      });
  write({"The drawing",
         decimal(size.x(), 1) + " × " + decimal(size.y(), 1) + " mm, " + job.pattern.format(),
         {},
         ""},
        picture);
  Canvas canvas(picture);
  rectangle(canvas, frame, size / 2, false);
  scale_bar(canvas, frame, side);
  return picture;
}

Picture lengths_preview(const Finished& job, int side) {
  const Vector2d size = job.pattern.size_mm();
  const Frame frame(size, side);
  Picture picture{side, side,
                  std::vector<std::uint32_t>(static_cast<std::size_t>(side) * side, bits(on_page))};
  const HeatMap scale = lengths_scale(job);
  write({std::string(scale.title()), scale.figures, &scale, ""}, picture);
  Canvas canvas(picture);
  rectangle(canvas, frame, size / 2, false);
  cairo_set_line_width(canvas.cairo(), 5);
  cairo_set_line_cap(canvas.cairo(), CAIRO_LINE_CAP_ROUND);
  for (auto piece = job.lengths.pieces.rbegin(); piece != job.lengths.pieces.rend(); ++piece) {
    for (const Vector2d& p : piece->drawn) {
      const Vector2d at = frame.pixel(p);
      cairo_line_to(canvas.cairo(), at.x(), at.y());
    }
    canvas.colour(scale.colour(100 * piece->error));
    cairo_stroke(canvas.cairo());
  }
  return picture;
}

Picture print_preview(const Finished& job, const SheetPicture& print, int side) {
  const Vector2d size(job.settings.sheet.width_mm, job.settings.sheet.height_mm);
  const Frame frame(size, side);
  const double blur = 0.6 / frame.pixels_per_mm;
  const PlaneLocator chart(job.sheet.triangles, job.sheet.rest, job.flattening.triangles);
  const bool mirrored = job.print.main().mirrored();
  const bool gray = in_black(job.print);
  Picture picture =
      painted(frame, side, [&](const Vector2d& start, const Vector2d& step, std::span<Rgb> out) {
        for (std::size_t k = 0; k < out.size(); ++k) {
          const Vector2d at = start + static_cast<double>(k) * step;
          const Vector2d rest(mirrored ? -at.x() : at.x(), at.y());
          out[k] = outside(at, size)
                       ? backdrop
                       : laid_over(chart.find(rest) ? on_mold : paper, print.sample(rest, blur), gray);
        }
      });
  const std::string face = mirrored ? "for the inner face, mirrored as it is printed" : "for the outer face";
  write({"The pre-distorted print on the flat sheet",
         decimal(size.x(), 0) + " × " + decimal(size.y(), 0) + " mm, " + face,
         {},
         // The colours of a scan cover what lies on the mold.
         std::string(job.print.main().source->colours() ? "" : "Blue: comes to lie on the mold. ") +
             "Dashed: the window of the clamp frame."},
        picture);
  Canvas canvas(picture);
  rectangle(canvas, frame, size / 2, false);
  const auto& machine = job.settings.machine;
  if (machine.window == WindowShape::rectangle) {
    rectangle(canvas, frame, Vector2d(machine.window_width_mm, machine.window_height_mm) / 2, true);
  } else {
    constexpr double dash[] = {8, 6};
    const Vector2d middle = frame.pixel({0, 0});
    cairo_set_dash(canvas.cairo(), dash, 2, 0);
    cairo_arc(canvas.cairo(), middle.x(), middle.y(), machine.window_width_mm / 2 * frame.pixels_per_mm, 0,
              2 * M_PI);
    cairo_stroke(canvas.cairo());
  }
  scale_bar(canvas, frame, side);
  const SideLetters letters = side_letters(job.mold.findings.left_side);
  constexpr double away = 24, above = 15;
  const Vector2d upper_left = frame.pixel({-size.x() / 2, size.y() / 2}),
                 lower_right = frame.pixel({size.x() / 2, -size.y() / 2});
  write_letter(canvas, letters.plus_y, frame.middle_x, upper_left.y() - above);
  write_letter(canvas, letters.minus_y, frame.middle_x, lower_right.y() + above);
  write_letter(canvas, mirrored ? letters.plus_x : letters.minus_x, upper_left.x() - away, frame.middle_y);
  write_letter(canvas, mirrored ? letters.minus_x : letters.plus_x, lower_right.x() + away, frame.middle_y);
  return picture;
}

}  // namespace vacuform
