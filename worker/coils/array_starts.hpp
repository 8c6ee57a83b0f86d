// Where the loops of an array may begin: spread evenly over a region of the chart, or at the nodes of a lattice.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "api/settings.hpp"
#include "worker/coils/array_relaxation.hpp"
#include "worker/placement/element_layout.hpp"

namespace vacuform {

// The width of the line of a loop: less for small loops, so that bridges and gaps have room between its crossings.
inline constexpr double widest_trace_mm = 3;
inline double loop_trace_mm(double radius_mm) {
  return std::clamp(std::floor(radius_mm / 0.9) / 10, 1.0, widest_trace_mm);
}
inline constexpr double critical =
    0.75;  // spacing over diameter that decouples: 0.758 on a plane, 0.736 on a small head

// Starts for one wish on one chart.
class ArrayStarts {
 public:
  ArrayStarts(const ChartedSurface& charted, const LayoutSettings& wish);
  // The part of the chart that the wish's region is.
  Half half() const;
  // The share of that region's area that lies within a loop.
  double covered(const ElementLayout& layout) const;
  // Loops of one size, evenly spread (a centroidal Voronoi tessellation that begins with a lattice turned by `turn`, and
  // settles if asked to), `extra_mm` farther from the border than they need. Errors: unusable_surface (they do not fit),
  // cancelled.
  Result<ElementLayout> spread(double extra_mm, bool settle, double turn, const Context& context) const;
  // The same with equal distances of neighbours.
  Result<ElementLayout> equally_spread(double extra_mm, bool settle, const Context& context) const;
  // Of loops that are spread over the region, the place on the chart from which the farthest one is nearest.
  Eigen::Vector2d middle(const ElementLayout& layout) const;
  // The layout's centres, nearer to `middle`.
  std::vector<Centre> drawn_together(const ElementLayout& layout, const Eigen::Vector2d& middle,
                                     double share) const;
  // The nodes of a hexagonal lattice that are nearest to `middle`: on a node of it, or the middle of an edge or a triangle
  // (kind 0, 1, 2).
  std::vector<Centre> hexagons(const Eigen::Vector2d& middle, double spacing, double turn, int kind) const;

 private:
  struct Domain;
  Domain domain_within(double margin_mm) const;
  Domain about_middle(const Domain& whole, double area) const;
  Result<Domain> domain_for(double extra_mm) const;
  std::vector<Eigen::Vector3d> lattice(const Domain& domain, double turn) const;

  const ChartedSurface& charted_;
  const LayoutSettings& wish_;
  std::vector<double> area_;       // per vertex of the sheet, mm2; 0 off the chart
  std::vector<double> to_border_;  // mm in space to the chart's border, of the chart's vertices
};

// A circle of an array.
LaidElement loop_of(int number, double radius_mm);

// Centres by chart coordinates.
std::vector<Centre> centres_at(const ChartedSurface& charted, const std::vector<Eigen::Vector2d>& places);

// Sorts them from the back to the front, and from left to right where that is the same. The order of what was where.
std::vector<int> sort_by_place(const ChartedSurface& charted, std::vector<Centre>& centres);

// Takes as neighbours those that are by the distances as they are now, by the measure of a drawing's (spacing.hpp); whether
// they have changed.
bool find_neighbours(const InkedSurface& surface, ElementLayout& layout, double spacing_mm);

// Along the surface, mm.
double distance(const InkedSurface& surface, const ElementLayout& layout, const Neighbours& pair);

}  // namespace vacuform
