#include "worker/coils/array_starts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "worker/placement/spacing.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/voronoi.hpp"

namespace vacuform {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const double hexagon = std::sqrt(3.0) / 2;  // area of a cell over its spacing squared

// Spacing over diameter.
double ratio_of(const LayoutSettings& wish) { return wish.overlap > 0 ? wish.overlap : critical; }

// A loop's centre stays half a cell from the border of what is tessellated, and its line reaches farther.
double margin_for(double spacing_mm, double ratio) {
  return (0.5 / ratio - 0.5) * spacing_mm + widest_trace_mm / 2 + 1;
}

// A corner of one of the chart's triangles.
SheetPoint point_at(const ChartedSurface& charted, int vertex) {
  const std::vector<int>& triangles = charted.flattening().triangles;
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k)
      if (charted.surface().triangles()[index(t)][index(k)] == vertex) return {t, Vector3d::Unit(k)};
  return {triangles.front(), Vector3d::Unit(0)};
}

ElementLayout element_layout(const ChartedSurface& charted, const Tessellation& cells) {
  ElementLayout out;
  for (const int v : cells.sites) {
    Centre centre;
    centre.point = point_at(charted, v);
    centre.axis = charted.axis(centre.point.triangle);
    centre.drawn = charted.flattening().chart[index(v)];
    out.centres.push_back(centre);
  }
  const std::vector<int> order = sort_by_place(charted, out.centres);
  std::vector<int> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[index(order[i])] = static_cast<int>(i);
  for (const auto& [a, b] : cells.touch)
    out.pairs.push_back(
        {std::min(place[index(a)], place[index(b)]), std::max(place[index(a)], place[index(b)]), 0});
  return out;
}

// Cells that touch in a short border are farther apart than neighbours are.
void drop_distant(const InkedSurface& surface, ElementLayout& layout) {
  std::vector<double> nearest(layout.centres.size(), std::numeric_limits<double>::infinity()), mm;
  for (const Neighbours& n : layout.pairs) {
    mm.push_back(distance(surface, layout, n));
    for (const int i : {n.a, n.b}) nearest[index(i)] = std::min(nearest[index(i)], mm.back());
  }
  std::vector<Neighbours> kept;
  for (std::size_t p = 0; p < mm.size(); ++p)
    if (mm[p] <= 1.25 * std::max(nearest[index(layout.pairs[p].a)], nearest[index(layout.pairs[p].b)]))
      kept.push_back(layout.pairs[p]);
  layout.pairs = std::move(kept);
}

// The least distance of two centres in space, mm.
double nearest_two(const InkedSurface& surface, const ElementLayout& layout) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < layout.centres.size(); ++a)
    for (std::size_t b = a + 1; b < layout.centres.size(); ++b)
      least = std::min(
          least, (surface.place(layout.centres[a].point) - surface.place(layout.centres[b].point)).norm());
  return least;
}

}  // namespace

// Vertices of the chart that may take a centre, with their areas.
struct ArrayStarts::Domain {
  std::vector<int> vertices;
  std::vector<double> areas;
  double area = 0;
};

ArrayStarts::ArrayStarts(const ChartedSurface& charted, const LayoutSettings& wish)
    : charted_(charted), wish_(wish), area_(charted.surface().inked().size(), 0), to_border_(area_) {
  const InkedSurface& surface = charted.surface();
  for (const int t : charted.flattening().triangles) {
    const Triangle& c = surface.triangles()[index(t)];
    const auto at = [&](std::size_t k) -> const Vector3d& { return surface.inked()[index(c[k])]; };
    const double third = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 6;
    for (const int v : c) area_[index(v)] += third;
  }
  const std::vector<Vector3d> border = charted.border();
  for (std::size_t v = 0; v < area_.size(); ++v) {
    if (area_[v] == 0) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& b : border) least = std::min(least, (surface.inked()[v] - b).squaredNorm());
    to_border_[v] = std::sqrt(least);
  }
}

Half ArrayStarts::half() const {
  const InkedSurface& surface = charted_.surface();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t v = 0; v < area_.size(); ++v)
    if (area_[v] > 0)
      low = std::min(low, surface.inked()[v].y()), high = std::max(high, surface.inked()[v].y());
  const int side = wish_.region == ArrayRegion::front ? 1 : wish_.region == ArrayRegion::back ? -1 : 0;
  return {(low + high) / 2, side};
}

double ArrayStarts::covered(const ElementLayout& layout) const {
  const InkedSurface& surface = charted_.surface();
  const Domain region = domain_within(0);
  double area = 0;
  for (std::size_t v = 0; v < region.vertices.size(); ++v) {
    const Vector3d& place = surface.inked()[index(region.vertices[v])];
    for (std::size_t i = 0; i < layout.centres.size(); ++i)
      if ((surface.place(layout.centres[i].point) - place).norm() <=
          layout.elements[i].size * layout.elements[i].outline.radius_mm) {
        area += region.areas[v];
        break;
      }
  }
  return area / region.area;
}

ArrayStarts::Domain ArrayStarts::domain_within(double margin_mm) const {
  const Half part = half();
  Domain out;
  for (std::size_t v = 0; v < area_.size(); ++v) {
    if (area_[v] == 0 || to_border_[v] < margin_mm || part.outside_mm(charted_.surface().inked()[v]) > 0)
      continue;
    out.vertices.push_back(static_cast<int>(v));
    out.areas.push_back(area_[v]);
    out.area += area_[v];
  }
  return out;
}

// The part of the domain about its middle, on a dome about the top, that holds an area.
ArrayStarts::Domain ArrayStarts::about_middle(const Domain& whole, double area) const {
  const std::vector<Vector3d>& inked = charted_.surface().inked();
  Vector3d middle = Vector3d::Zero();
  for (std::size_t i = 0; i < whole.vertices.size(); ++i)
    middle += whole.areas[i] / whole.area * inked[index(whole.vertices[i])];
  if (wish_.region == ArrayRegion::dome) middle = charted_.surface().place(charted_.at_chart({0, 0}).point);
  std::vector<std::size_t> order(whole.vertices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto far = [&](std::size_t i) { return (inked[index(whole.vertices[i])] - middle).squaredNorm(); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return far(a) < far(b); });
  Domain out;
  for (std::size_t i = 0; i < order.size() && out.area < area; ++i) {
    out.vertices.push_back(whole.vertices[order[i]]);
    out.areas.push_back(whole.areas[order[i]]);
    out.area += whole.areas[order[i]];
  }
  return out;
}

// The nodes of a hexagonal lattice on the chart that are nearest to the middle of the domain.
std::vector<Vector3d> ArrayStarts::lattice(const Domain& domain, double turn) const {
  const int count = wish_.count;
  Vector2d middle = Vector2d::Zero();
  for (const int v : domain.vertices)
    middle += charted_.flattening().chart[index(v)] / static_cast<double>(domain.vertices.size());
  const double spacing = std::sqrt(domain.area / (hexagon * count));
  std::vector<Vector2d> nodes;
  for (int j = -count; j <= count; ++j)
    for (int i = -count; i <= count; ++i) nodes.push_back(spacing * Vector2d(i + 0.5 * (j & 1), hexagon * j));
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const Vector2d& a, const Vector2d& b) { return a.squaredNorm() < b.squaredNorm(); });
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i)
    out.push_back(charted_.surface().place(
        charted_.at_chart(middle + Eigen::Rotation2Dd(turn) * nodes[index(i)]).point));
  return out;
}

// The region's domain, `extra_mm` farther from the border than the loops need.
Result<ArrayStarts::Domain> ArrayStarts::domain_for(double extra_mm) const {
  const auto refuse = [&](const std::string& fix) {
    return fail(Code::unusable_surface, std::to_string(wish_.count) + " loops do not fit on the region",
                "layout.count", fix);
  };
  const bool fitted = wish_.diameter_mm == 0;
  double spacing = wish_.diameter_mm * ratio_of(wish_);
  Domain out = domain_within(extra_mm + margin_for(spacing, ratio_of(wish_)));
  if (!fitted) {
    const double cell = hexagon * spacing * spacing;
    if (out.area < wish_.count * cell)
      return refuse("about " + std::to_string(static_cast<int>(out.area / cell)) + " of this diameter fit");
    out = about_middle(out, wish_.count * cell);
  }
  constexpr int rounds = 4;  // spacing and margin depend on each other
  for (int round = 0; fitted && round < rounds; ++round) {
    spacing = std::sqrt(out.area / (hexagon * wish_.count));
    out = domain_within(extra_mm + margin_for(spacing, ratio_of(wish_)));
  }
  if (out.vertices.size() < 4 * index(wish_.count))
    return refuse("give fewer, or a finer sheet.resolution_mm");
  return out;
}

Result<ElementLayout> ArrayStarts::spread(double extra_mm, bool settle, double turn,
                                          const Context& context) const {
  const InkedSurface& surface = charted_.surface();
  VACUFORM_TRY(where, domain_for(extra_mm));
  const Tessellation cells = tessellate(surface, where.vertices, where.areas, lattice(where, turn), settle);
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  ElementLayout layout = element_layout(charted_, cells);
  drop_distant(surface, layout);
  double sum = 0;
  for (const Neighbours& n : layout.pairs) sum += distance(surface, layout, n);
  const double ratio = ratio_of(wish_), mean = sum / std::max(1.0, static_cast<double>(layout.pairs.size())),
               diameter = wish_.diameter_mm > 0 ? wish_.diameter_mm : mean / ratio;
  for (int i = 0; i < wish_.count; ++i) {
    layout.elements.push_back(loop_of(i, diameter / 2));
    layout.centres[index(i)].radius_mm = diameter / 2;
  }
  return layout;
}

Result<ElementLayout> ArrayStarts::equally_spread(double extra_mm, bool settle,
                                                  const Context& context) const {
  VACUFORM_TRY(layout, spread(extra_mm, settle, 0, context));
  const InkedSurface& surface = charted_.surface();
  const double spacing = ratio_of(wish_) * 2 * layout.elements.front().outline.radius_mm;
  // Where the centres have moved, others may be neighbours. Where no distances are equal, least squares may fold the array
  // over itself: then it stays as the cells are.
  constexpr int rounds = 4;
  constexpr double least_apart = 0.8;
  for (int round = 0; round < rounds; ++round) {
    for (Neighbours& n : layout.pairs) n.drawn_mm = spacing;
    const std::vector<Centre> before = layout.centres;
    VACUFORM_CHECK(multilaterate(charted_, layout.centres, layout.pairs, context));
    for (Centre& c : layout.centres) c.moved.setZero();
    if (nearest_two(surface, layout) < least_apart * spacing) {
      layout.centres = before;
      break;
    }
    if (!find_neighbours(surface, layout, spacing)) break;
  }
  return layout;
}

Vector2d ArrayStarts::middle(const ElementLayout& layout) const {
  const InkedSurface& surface = charted_.surface();
  std::vector<Vector3d> places;
  for (const Centre& c : layout.centres) places.push_back(surface.place(c.point));
  double least = std::numeric_limits<double>::infinity();
  Vector2d out = Vector2d::Zero();
  for (const int v : domain_within(0).vertices) {
    double farthest = 0;
    for (const Vector3d& place : places)
      farthest = std::max(farthest, (place - surface.inked()[index(v)]).squaredNorm());
    if (farthest < least) least = farthest, out = charted_.flattening().chart[index(v)];
  }
  return out;
}

std::vector<Centre> ArrayStarts::drawn_together(const ElementLayout& layout, const Vector2d& middle,
                                                double share) const {
  std::vector<Vector2d> places;
  for (const Centre& c : layout.centres) {
    const Vector2d place = charted_.on_chart(c.point.triangle) ? charted_.chart(c.point) : c.drawn;
    places.push_back(middle + share * (place - middle));
  }
  return centres_at(charted_, places);
}

std::vector<Centre> ArrayStarts::hexagons(const Vector2d& middle, double spacing, double turn,
                                          int kind) const {
  const int count = wish_.count;
  const Vector2d from = kind == 0   ? Vector2d(0, 0)
                        : kind == 1 ? Vector2d(0.5, 0)
                                    : Vector2d(0.5, hexagon / 3);
  std::vector<Vector2d> nodes;
  const int reach = 3 + static_cast<int>(std::sqrt(count));
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i)
      nodes.push_back(spacing * (from + Vector2d(i + 0.5 * (j & 1), hexagon * j)));
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const Vector2d& a, const Vector2d& b) { return a.squaredNorm() < b.squaredNorm(); });
  nodes.resize(index(count));
  for (Vector2d& node : nodes) node = middle + Eigen::Rotation2Dd(turn) * node;
  return centres_at(charted_, nodes);
}

LaidElement loop_of(int number, double radius) {
  LaidElement out{number, {}, 1};
  constexpr int points = 96;
  for (int i = 0; i < points; ++i)
    out.outline.loop.push_back(radius *
                               Vector2d(std::cos(2 * M_PI * i / points), std::sin(2 * M_PI * i / points)));
  out.outline.points = out.outline.loop;
  out.outline.radius_mm = radius;
  out.outline.reach_mm = radius + widest_trace_mm;
  out.outline.width_mm = loop_trace_mm(radius);
  return out;
}

std::vector<Centre> centres_at(const ChartedSurface& charted, const std::vector<Vector2d>& places) {
  std::vector<Centre> out;
  for (const Vector2d& place : places) {
    Centre centre;
    centre.point = charted.at_chart(place).point;
    centre.axis = charted.axis(centre.point.triangle);
    centre.drawn = place;
    out.push_back(centre);
  }
  return out;
}

std::vector<int> sort_by_place(const ChartedSurface& charted, std::vector<Centre>& centres) {
  for (Centre& c : centres)
    if (charted.on_chart(c.point.triangle)) c.drawn = charted.chart(c.point);
  std::vector<int> order(centres.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const Vector2d &p = centres[index(a)].drawn, &q = centres[index(b)].drawn;
    return p.y() != q.y() ? p.y() < q.y() : p.x() < q.x();
  });
  std::vector<Centre> sorted;
  for (const int i : order) sorted.push_back(centres[index(i)]);
  centres = std::move(sorted);
  return order;
}

double distance(const InkedSurface& surface, const ElementLayout& layout, const Neighbours& pair) {
  return connect(surface, layout.centres[index(pair.a)].point, layout.centres[index(pair.b)].point).mm;
}

bool find_neighbours(const InkedSurface& surface, ElementLayout& layout, double spacing_mm) {
  ElementLayout near;
  near.centres = layout.centres;
  for (std::size_t a = 0; a < near.centres.size(); ++a)
    for (std::size_t b = a + 1; b < near.centres.size(); ++b)
      if ((surface.place(near.centres[a].point) - surface.place(near.centres[b].point)).norm() <
          1.4 * spacing_mm)
        near.pairs.push_back({static_cast<int>(a), static_cast<int>(b), 0});
  drop_distant(surface, near);
  const bool same =
      std::equal(near.pairs.begin(), near.pairs.end(), layout.pairs.begin(), layout.pairs.end(),
                 [](const Neighbours& p, const Neighbours& q) { return p.a == q.a && p.b == q.b; });
  layout.pairs = std::move(near.pairs);
  return !same;
}

}  // namespace vacuform
