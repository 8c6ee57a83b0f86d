#include "worker/printing/inked_rings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <utility>

namespace vacuform {

std::vector<Ring> inked_rings(const VectorPrint& vectors, double tolerance_mm) {
  constexpr std::size_t most_work = 5'000'000;  // comparisons, and points that white is taken away from
  std::size_t work = 0;
  std::vector<std::pair<Area, Eigen::AlignedBox2d>> inked;
  const auto box_around = [](const Area& area) {
    Eigen::AlignedBox2d box;
    for (const Ring& ring : area)
      for (const Eigen::Vector2d& p : ring) box.extend(p);
    return box;
  };
  for (const PrintedElement& element : vectors.elements)
    for (const PaintedArea& area : element.areas) {
      Area painted = fill_area(area.outlines, area.even_odd, tolerance_mm);
      const Eigen::AlignedBox2d box = box_around(painted);
      if (area.colour.ink() > 0) {
        inked.emplace_back(std::move(painted), box);
      } else if (area.colour.a == 1) {
        for (auto& [below, around] : inked) {
          if (++work > most_work) break;
          if (!around.intersects(box)) continue;
          for (const Ring& ring : below) work += ring.size();
          below = difference(below, painted);
        }
      }
    }
  std::vector<Ring> rings;
  for (auto& [area, box] : inked) std::move(area.begin(), area.end(), std::back_inserter(rings));
  return rings;
}

}  // namespace vacuform
