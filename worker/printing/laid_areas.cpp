#include "worker/printing/laid_areas.hpp"

#include <utility>

#include "worker/printing/curve_fit.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

constexpr double laid_tolerance_mm = 0.01;

Curve outline_of(const Ring& ring) {
  constexpr double corner = 0.9;  // cosine; 26 degrees
  std::vector<FitPoint> points;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d in = ring[i] - ring[(i + ring.size() - 1) % ring.size()],
                          on = ring[(i + 1) % ring.size()] - ring[i];
    points.push_back({ring[i], in.dot(on) < corner * in.norm() * on.norm()});
  }
  return fit_curve(points, true, laid_tolerance_mm);
}

Curve middle_of(const std::vector<Eigen::Vector2d>& line) {
  std::vector<FitPoint> points;
  for (const Eigen::Vector2d& p : line) points.push_back({p, false});
  return fit_curve(points, false, laid_tolerance_mm);
}

}  // namespace

void add_laid_ink(const std::vector<LaidInkArea>& ink, VectorPrint& vectors) {
  for (const LaidInkArea& each : ink) {
    PrintedElement& element = vectors.elements[index(each.element)];
    PaintedArea area{{}, false, {0, 0, 0, 1}};
    for (const Ring& ring : each.area) area.outlines.push_back(outline_of(ring));
    if (area.outlines.empty()) continue;
    element.areas.push_back(std::move(area));
    vectors.painted_mm2 += square_mm(each.area);
    if (each.line.size() > 1) element.centrelines.push_back({middle_of(each.line), each.width_mm});
  }
}

}  // namespace vacuform
