// Drawings of every format, as pictures and, of SVG, as lines.
#include <cmath>

#include "tests/fuzz/targets.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/drawing.hpp"
#include "worker/pattern/pattern.hpp"

namespace vacuform::fuzz {
namespace {

void check(const Pattern& pattern) {
  require(pattern.ink_mm2() > 0 && std::isfinite(pattern.ink_mm2()), "a pattern has ink");
  const Eigen::Vector2d size = pattern.size_mm();
  for (const double x : {-0.6, -0.5, 0.0, 0.25, 0.5})
    for (const double blur : {0.01, 1.0, 1000.0}) {
      const Ink ink = pattern.sample({x * size.x(), -x * size.y()}, blur);
      require(ink.coverage() >= -1e-4f && ink.coverage() <= 1.0001f, "coverage is a share");
    }
}

void check(const Drawing& drawing) {
  for (const Element& element : drawing.elements)
    for (const Shape& shape : element.shapes) {
      for (const Curve& curve : shape.curves) {
        require(curve.points.size() % 3 == 1, "a curve is whole segments");
        for (const Eigen::Vector2d& p : curve.points) require(p.allFinite(), "a curve is finite");
      }
      // As the print makes them.
      if (shape.fill)
        require(square_mm(fill_area(shape.curves, shape.even_odd, 0.002)) >= -1, "a fill has an area");
      if (shape.stroke)
        require(square_mm(stroke_area(shape.curves, *shape.stroke, 0.002)) >= -1, "a line has an area");
    }
}

void read(Bytes bytes, const char* file_name) {
  PatternSettings settings;
  if (bytes.size() % 2 == 0) settings.width_mm = 100;
  const auto pattern = Pattern::read(bytes, file_name, settings, 300);
  if (!pattern)
    return require(pattern.error().code != Code::internal, "a bad drawing is no fault of Vacuform's");
  check(*pattern);
  std::vector<Warning> warnings;
  if (const auto drawing = read_drawing(*pattern, warnings)) check(*drawing);
}

}  // namespace

void read_png(Bytes bytes) { read(bytes, "fuzz.png"); }
void read_jpeg(Bytes bytes) { read(bytes, "fuzz.jpg"); }
void read_svg(Bytes bytes) { read(bytes, "fuzz.svg"); }

}  // namespace vacuform::fuzz
