#include "worker/coils/array_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/coils/array_relaxation.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/coils/decoupling.hpp"
#include "worker/coils/metric_mds.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/sorting.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/stage/sub_progress.hpp"
#include "worker/surface/voronoi.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double critical =
    0.75;  // spacing over diameter that decouples: 0.758 on a plane, 0.736 on a small head
const double hexagon = std::sqrt(3.0) / 2;  // area of a cell over its spacing squared

// Vertices of the chart that may take a centre, with their areas.
struct SamplingDomain {
  std::vector<int> vertices;
  std::vector<double> areas;
  double area = 0;
};

struct ChartVertices {
  std::vector<double> area;       // per vertex of the sheet; 0 off the chart
  std::vector<double> to_border;  // mm in space to the chart's border, of the chart's vertices
};

ChartVertices chart_vertices(const ChartedSurface& charted) {
  const InkedSurface& surface = charted.surface();
  ChartVertices out{std::vector<double>(surface.inked().size(), 0), {}};
  for (const int t : charted.flattening().triangles) {
    const Triangle& c = surface.triangles()[index(t)];
    const auto at = [&](std::size_t k) -> const Vector3d& { return surface.inked()[index(c[k])]; };
    const double third = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 6;
    for (const int v : c) out.area[index(v)] += third;
  }
  const std::vector<Vector3d> border = charted.border();
  out.to_border.assign(out.area.size(), 0);
  for (std::size_t v = 0; v < out.area.size(); ++v) {
    if (out.area[v] == 0) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& b : border) least = std::min(least, (surface.inked()[v] - b).squaredNorm());
    out.to_border[v] = std::sqrt(least);
  }
  return out;
}

// The part of the chart that a region is.
Half half_of(const ChartVertices& vertices, const InkedSurface& surface, ArrayRegion region) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t v = 0; v < vertices.area.size(); ++v)
    if (vertices.area[v] > 0)
      low = std::min(low, surface.inked()[v].y()), high = std::max(high, surface.inked()[v].y());
  const int side = region == ArrayRegion::front ? 1 : region == ArrayRegion::back ? -1 : 0;
  return {(low + high) / 2, side};
}

SamplingDomain sampling_domain(const InkedSurface& surface, const ChartVertices& vertices, ArrayRegion region,
                               double margin_mm) {
  const Half half = half_of(vertices, surface, region);
  SamplingDomain out;
  for (std::size_t v = 0; v < vertices.area.size(); ++v) {
    if (vertices.area[v] == 0 || vertices.to_border[v] < margin_mm || half.outside_mm(surface.inked()[v]) > 0)
      continue;
    out.vertices.push_back(static_cast<int>(v));
    out.areas.push_back(vertices.area[v]);
    out.area += vertices.area[v];
  }
  return out;
}

// Spacing over diameter.
double ratio_of(const LayoutSettings& wish) { return wish.overlap > 0 ? wish.overlap : critical; }

// A loop's centre stays half a cell from the border of what is tessellated, and its line reaches farther.
double margin_for(double spacing_mm, double ratio) {
  return (0.5 / ratio - 0.5) * spacing_mm + loop_trace_mm / 2 + 1;
}

// The part of the domain about its middle that holds an area; `middle` in space.
SamplingDomain about_middle(const InkedSurface& surface, const SamplingDomain& whole, const Vector3d& middle,
                            double area) {
  std::vector<std::size_t> order(whole.vertices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto far = [&](std::size_t i) {
    return (surface.inked()[index(whole.vertices[i])] - middle).squaredNorm();
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return far(a) < far(b); });
  SamplingDomain out;
  for (std::size_t i = 0; i < order.size() && out.area < area; ++i) {
    out.vertices.push_back(whole.vertices[order[i]]);
    out.areas.push_back(whole.areas[order[i]]);
    out.area += whole.areas[order[i]];
  }
  return out;
}

Vector3d middle_of(const InkedSurface& surface, const SamplingDomain& domain, const Vector3d& top,
                   ArrayRegion region) {
  if (region == ArrayRegion::dome) return top;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < domain.vertices.size(); ++i)
    sum += domain.areas[i] * surface.inked()[index(domain.vertices[i])];
  return sum / domain.area;
}

// The `count` nodes of a hexagonal lattice on the chart that are nearest to the middle of the domain.
std::vector<Vector3d> lattice(const ChartedSurface& charted, const SamplingDomain& domain, int count,
                              double turn) {
  Vector2d middle = Vector2d::Zero();
  for (const int v : domain.vertices)
    middle += charted.flattening().chart[index(v)] / static_cast<double>(domain.vertices.size());
  const double spacing = std::sqrt(domain.area / (hexagon * count));
  std::vector<Vector2d> nodes;
  for (int j = -count; j <= count; ++j)
    for (int i = -count; i <= count; ++i) nodes.push_back(spacing * Vector2d(i + 0.5 * (j & 1), hexagon * j));
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const Vector2d& a, const Vector2d& b) { return a.squaredNorm() < b.squaredNorm(); });
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i)
    out.push_back(
        charted.surface().place(charted.at_chart(middle + Eigen::Rotation2Dd(turn) * nodes[index(i)]).point));
  return out;
}

LaidElement loop_of(int number, double radius) {
  LaidElement out{number, {}, 1};
  constexpr int points = 96;
  for (int i = 0; i < points; ++i)
    out.outline.loop.push_back(radius *
                               Vector2d(std::cos(2 * M_PI * i / points), std::sin(2 * M_PI * i / points)));
  out.outline.points = out.outline.loop;
  out.outline.radius_mm = radius;
  out.outline.reach_mm = radius + loop_trace_mm;
  out.outline.width_mm = loop_trace_mm;
  return out;
}

// A corner of one of the chart's triangles.
SheetPoint point_at(const ChartedSurface& charted, int vertex) {
  const std::vector<int>& triangles = charted.flattening().triangles;
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k)
      if (charted.surface().triangles()[index(t)][index(k)] == vertex) return {t, Vector3d::Unit(k)};
  return {triangles.front(), Vector3d::Unit(0)};
}

// From the back to the front, and from left to right where that is the same. The order of what was where.
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

double distance(const InkedSurface& surface, const ElementLayout& layout, const Neighbours& n) {
  return connect(surface, layout.centres[index(n.a)].point, layout.centres[index(n.b)].point).mm;
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

// Neighbours by the distances as they are now, by the measure of a drawing's (spacing.hpp). Whether they have changed.
bool find_pairs(const InkedSurface& surface, ElementLayout& layout, double spacing_mm) {
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

Element ring(const std::string& id, const Vector2d& centre, double radius) {
  Shape shape;
  shape.curves.push_back(circle(centre, radius));
  shape.stroke = Stroke{};
  shape.stroke->width_mm = loop_trace_mm;
  return one_element(id, {std::move(shape)});
}

Drawing drawing_of(const ElementLayout& layout, const std::vector<Vector2d>& picture) {
  Drawing out;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double radius = layout.elements[i].size * layout.elements[i].outline.radius_mm;
    out.elements.push_back(ring("coil-" + std::to_string(i + 1), picture[i], radius));
    out.size_mm =
        out.size_mm.cwiseMax(2 * (picture[i].cwiseAbs() + Vector2d::Constant(radius + loop_trace_mm)));
  }
  return out;
}

// The region's domain for the wish, `extra_mm` farther from the border than the loops need.
Result<SamplingDomain> domain_for(const ChartedSurface& charted, const ChartVertices& vertices,
                                  const LayoutSettings& wish, double extra_mm) {
  const InkedSurface& surface = charted.surface();
  const auto refuse = [&](const std::string& fix) {
    return fail(Code::unusable_surface, std::to_string(wish.count) + " loops do not fit on the region",
                "layout.count", fix);
  };
  const bool fitted = wish.diameter_mm == 0;
  double spacing = wish.diameter_mm * ratio_of(wish);
  SamplingDomain out =
      sampling_domain(surface, vertices, wish.region, extra_mm + margin_for(spacing, ratio_of(wish)));
  if (!fitted) {
    const double cell = hexagon * spacing * spacing;
    if (out.area < wish.count * cell)
      return refuse("about " + std::to_string(static_cast<int>(out.area / cell)) + " of this diameter fit");
    const Vector3d top = surface.place(charted.at_chart({0, 0}).point);
    out = about_middle(surface, out, middle_of(surface, out, top, wish.region), wish.count * cell);
  }
  constexpr int rounds = 4;  // spacing and margin depend on each other
  for (int round = 0; fitted && round < rounds; ++round) {
    spacing = std::sqrt(out.area / (hexagon * wish.count));
    out = sampling_domain(surface, vertices, wish.region, extra_mm + margin_for(spacing, ratio_of(wish)));
  }
  if (out.vertices.size() < 4 * index(wish.count))
    return refuse("give fewer, or a finer sheet.resolution_mm");
  return out;
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

// Loops of one size, evenly spread.
Result<ElementLayout> spread(const ChartedSurface& charted, const ChartVertices& vertices,
                             const LayoutSettings& wish, double extra_mm, bool settle, double turn,
                             const Context& context) {
  const InkedSurface& surface = charted.surface();
  VACUFORM_TRY(where, domain_for(charted, vertices, wish, extra_mm));
  const Tessellation cells =
      tessellate(surface, where.vertices, where.areas, lattice(charted, where, wish.count, turn), settle);
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  ElementLayout layout = element_layout(charted, cells);
  drop_distant(surface, layout);
  double sum = 0;
  for (const Neighbours& n : layout.pairs) sum += distance(surface, layout, n);
  const double ratio = ratio_of(wish), mean = sum / std::max(1.0, static_cast<double>(layout.pairs.size())),
               diameter = wish.diameter_mm > 0 ? wish.diameter_mm : mean / ratio;
  for (int i = 0; i < wish.count; ++i) {
    layout.elements.push_back(loop_of(i, diameter / 2));
    layout.centres[index(i)].radius_mm = diameter / 2;
  }
  return layout;
}

// The same with equal distances of neighbours.
Result<ElementLayout> equally_spread(const ChartedSurface& charted, const ChartVertices& vertices,
                                     const LayoutSettings& wish, double extra_mm, bool settle,
                                     const Context& context) {
  VACUFORM_TRY(layout, spread(charted, vertices, wish, extra_mm, settle, 0, context));
  const InkedSurface& surface = charted.surface();
  const double spacing = ratio_of(wish) * 2 * layout.elements.front().outline.radius_mm;
  // Where the centres have moved, others may be neighbours. Where no distances are equal, least squares may fold the array
  // over itself: then it stays as the cells are.
  constexpr int rounds = 4;
  constexpr double least_apart = 0.8;
  for (int round = 0; round < rounds; ++round) {
    for (Neighbours& n : layout.pairs) n.drawn_mm = spacing;
    const std::vector<Centre> before = layout.centres;
    VACUFORM_CHECK(multilaterate(charted, layout.centres, layout.pairs, context));
    for (Centre& c : layout.centres) c.moved.setZero();
    if (nearest_two(surface, layout) < least_apart * spacing) {
      layout.centres = before;
      break;
    }
    if (!find_pairs(surface, layout, spacing)) break;
  }
  return layout;
}

int off_head(const std::vector<LaidCoil>& laid) {
  return static_cast<int>(
      std::count_if(laid.begin(), laid.end(), [](const LaidCoil& coil) { return !coil.element.on_head; }));
}

struct Trial {
  ElementLayout layout;
  std::vector<LaidCoil> laid;
};

std::optional<StrongestPair> strongest_neighbours(const Trial& trial) {
  std::optional<StrongestPair> out;
  for (const Neighbours& n : trial.layout.pairs)
    if (const auto k = coupling(trial.laid[index(n.a)], trial.laid[index(n.b)]);
        k && (!out || std::abs(*k) > std::abs(out->k)))
      out = StrongestPair{n.a, n.b, *k};
  return out;
}

// Above 1: neighbours couple by more than .01, others by more than unnulled_k, or all by more than .01 rms.
double excess_of(const Trial& trial, const CouplingMatrix& matrix) {
  const auto strongest = strongest_pair(matrix, [](int) { return true; });
  const auto neighbours = strongest_neighbours(trial);
  return std::max({strongest ? std::abs(strongest->k) / unnulled_k : 0,
                   neighbours ? std::abs(neighbours->k) / 0.01 : 0, rms(matrix) / 0.01});
}

Result<CouplingMatrix> couplings_of(const Trial& trial, const Context& context) {
  std::vector<InductiveLoop> loops;
  for (const LaidCoil& coil : trial.laid) loops.push_back({coil.element.loop, coil.self_nh});
  return coupling_matrix(loops, Stage::printing, 0, context);
}

// Loops as evenly spread as the wish's overlap asks; farther and farther from the border until none is off the head.
Result<Trial> overlapping(const ChartedSurface& charted, const ChartVertices& vertices,
                          const LayoutSettings& wish, const CoilSettings& coils, const Context& context) {
  constexpr double farther_mm = 2.5;
  const bool fitted = wish.diameter_mm == 0;
  const int most_ways = fitted ? 8 : 4;
  std::optional<Trial> best;
  for (int way = 0; way < most_ways; ++way) {
    auto layout = equally_spread(charted, vertices, wish, way * farther_mm, fitted || way % 2 == 1, context);
    if (!layout && layout.error().code != Code::cancelled && way > 0) break;  // no room for that
    VACUFORM_CHECK(layout);
    layout->keep = coils.keep;
    VACUFORM_TRY(laid, lay_coils(charted, *layout, context));
    Trial trial{*std::move(layout), std::move(laid)};
    if (!best || off_head(trial.laid) <= off_head(best->laid)) best = std::move(trial);
    if (off_head(best->laid) == 0) break;
  }
  return *std::move(best);
}

// Centres by chart coordinates.
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

// The layout's centres, nearer to their middle.
std::vector<Centre> drawn_together(const ChartedSurface& charted, const ElementLayout& layout, double share) {
  std::vector<Vector2d> places;
  Vector2d middle = Vector2d::Zero();
  for (const Centre& c : layout.centres) {
    places.push_back(charted.on_chart(c.point.triangle) ? charted.chart(c.point) : c.drawn);
    middle += places.back() / static_cast<double>(layout.centres.size());
  }
  for (Vector2d& place : places) place = middle + share * (place - middle);
  return centres_at(charted, places);
}

// The nodes of a hexagonal lattice that are nearest to `middle`: on a node of it, or the middle of an edge or a triangle.
std::vector<Centre> hexagons(const ChartedSurface& charted, const Vector2d& middle, int count, double spacing,
                             double turn, int kind) {
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
  return centres_at(charted, nodes);
}

// The best arrangement of each size, the largest first: from evenly spread centres and from hexagonal lattices.
Result<std::vector<Arrangement>> arrangements(const ChartedSurface& charted, const ChartVertices& vertices,
                                              const LayoutSettings& wish, const Context& context) {
  constexpr int most_sizes = 8, many = 32;
  constexpr double smaller = 0.935;
  const int ways = wish.count > many ? 2 : 3, lattice_turns = wish.count > many ? 2 : 5;
  const bool fitted = wish.diameter_mm == 0;
  std::vector<ElementLayout> spreads;
  for (int way = 0; way < ways; ++way) {
    auto layout = spread(charted, vertices, wish, 0, fitted || way > 0, way * M_PI / 3 / ways, context);
    if (!layout && layout.error().code != Code::cancelled && way > 0) break;
    VACUFORM_CHECK(layout);
    spreads.push_back(*std::move(layout));
  }
  const double largest = spreads.front().elements.front().outline.radius_mm;
  Vector2d middle = Vector2d::Zero();
  for (const Centre& c : spreads.front().centres) middle += c.drawn / wish.count;
  const Relaxation relaxation(charted, half_of(vertices, charted.surface(), wish.region));
  std::vector<Arrangement> out;
  for (int size = 0; size < (fitted ? most_sizes : 1); ++size) {
    VACUFORM_CHECK(context.step(Stage::printing, static_cast<double>(size) / most_sizes));
    const double share = std::pow(smaller, size), radius = share * largest;
    std::vector<std::vector<Centre>> starts;
    for (const ElementLayout& from : spreads)
      for (const double together : {1.0, share}) starts.push_back(drawn_together(charted, from, together));
    for (int turn = 0; turn < lattice_turns; ++turn)
      for (int kind = 0; kind < 3; ++kind)
        starts.push_back(hexagons(charted, middle, wish.count, 2 * critical * radius,
                                  turn * M_PI / 3 / lattice_turns, kind));
    std::vector<Arrangement> found(starts.size());
    in_parallel(0, static_cast<int>(starts.size()), [&](int first, int last) {
      for (std::size_t i = index(first); i < index(last); ++i)
        found[i] = relaxation.relaxed(std::move(starts[i]), radius, loop_trace_mm);
    });
    out.push_back(best_of(found));
    if (out.back().score() <= 1) break;
  }
  return out;
}

std::vector<CoupledLoops> coupled_loops(const InkedSurface& surface, const Trial& trial,
                                        const CouplingMatrix& matrix) {
  std::vector<CoupledLoops> out;
  std::set<std::pair<int, int>> neighbours;
  for (const Neighbours& n : trial.layout.pairs) neighbours.emplace(n.a, n.b);
  const auto id = [](int i) { return "coil-" + std::to_string(i + 1); };
  const auto radius = [&](int i) {
    const LaidElement& e = trial.layout.elements[index(i)];
    return e.size * e.outline.radius_mm;
  };
  for (int a = 0; a < matrix.count(); ++a)
    for (int b = a + 1; b < matrix.count(); ++b) {
      if (!trial.laid[index(a)].element.on_head || !trial.laid[index(b)].element.on_head) continue;
      const Vector3d p = surface.place(trial.layout.centres[index(a)].point),
                     q = surface.place(trial.layout.centres[index(b)].point);
      if (std::isfinite(matrix(a, b)))
        out.push_back({id(a), id(b), matrix(a, b), (p - q).norm(), (p + q) / 2, neighbours.contains({a, b}),
                       (p - q).norm() < overlap_share * (radius(a) + radius(b))});
    }
  return out;
}

Result<Trial> laid_out(const ChartedSurface& charted, const Arrangement& arrangement,
                       const CoilSettings& coils, const Context& context) {
  Trial out;
  out.layout.keep = coils.keep;
  out.layout.centres = arrangement.centres;
  sort_by_place(charted, out.layout.centres);
  for (Centre& centre : out.layout.centres) {
    out.layout.elements.push_back(
        loop_of(static_cast<int>(out.layout.elements.size()), arrangement.radius_mm));
    centre.radius_mm = arrangement.radius_mm;
  }
  VACUFORM_TRY(laid, lay_coils(charted, out.layout, context));
  out.laid = std::move(laid);
  VACUFORM_CHECK(decouple(charted, out.layout, out.laid, coils.size_limit, context));
  find_pairs(charted.surface(), out.layout, 2 * critical * arrangement.radius_mm);
  return out;
}

// The largest loops that couple as little as they should; else those that couple least.
Result<Trial> decoupled(const ChartedSurface& charted, const ChartVertices& vertices,
                        const LayoutSettings& wish, const CoilSettings& coils, const Context& context) {
  constexpr int most_tried = 3;
  constexpr double good = 1.35;
  const SubProgress first(context, {Stage::printing, 0, 0.5}), second(context, {Stage::printing, 0.5, 1});
  VACUFORM_TRY(found, arrangements(charted, vertices, wish, first.context()));
  std::size_t from = 0;  // decoupling takes a third off what is left
  while (from + 1 < found.size() && found[from].score() > good) ++from;
  if (found[from].score() > good) from = index(static_cast<int>(&best_of(found) - found.data()));
  std::optional<Trial> best;
  double least = 0;
  for (std::size_t i = from; i < std::min(found.size(), from + most_tried); ++i) {
    VACUFORM_TRY(trial, laid_out(charted, found[i], coils, second.context()));
    VACUFORM_TRY(matrix, couplings_of(trial, second.context()));
    const double excess = off_head(trial.laid) + excess_of(trial, matrix);
    if (!best || excess < least) best = std::move(trial), least = excess;
    if (least <= 1) break;
  }
  return *std::move(best);
}

// The picture with the places of its coils: each turned as its neighbours in the picture ask for.
Drawing with_places(const ChartedSurface& charted, const ElementLayout& layout,
                    const std::vector<Vector2d>& picture) {
  Drawing out = drawing_of(layout, picture);
  std::vector<Centre> centres = layout.centres;
  for (std::size_t i = 0; i < picture.size(); ++i) centres[i].drawn = picture[i];
  const std::vector<double> turn = turns(charted, centres, layout.pairs);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const Centre& c = centres[i];
    out.elements[i].place =
        CoilPlace{charted.surface().place(c.point),
                  turned(charted.surface(), c.point.triangle, c.axis, turn[i]), picture[i]};
  }
  return out;
}

// At, u, drawn, as the drawing's reader takes it (pattern/drawing.cpp).
std::string numbers_of(const CoilPlace& place) {
  std::string out;
  for (const double mm : place.at) out += decimal(mm, 4) + " ";
  for (const double share : place.u) out += decimal(share, 6) + " ";
  return out + decimal(place.drawn.x(), 4) + " " + decimal(place.drawn.y(), 4);
}

}  // namespace

Result<Array> lay_out_array(const ChartedSurface& charted, const LayoutSettings& wish,
                            const CoilSettings& coils, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  const SubProgress first(context, {Stage::printing, 0, 0.8}), last(context, {Stage::printing, 0.8, 1});
  const InkedSurface& surface = charted.surface();
  const ChartVertices vertices = chart_vertices(charted);
  VACUFORM_TRY(best, wish.overlap > 0 ? overlapping(charted, vertices, wish, coils, first.context())
                                      : decoupled(charted, vertices, wish, coils, first.context()));
  const auto& [layout, laid] = best;

  Array out;
  out.diameter_mm = 2 * layout.elements.front().outline.radius_mm;
  out.pairs = static_cast<int>(layout.pairs.size());
  out.off_head = off_head(laid);
  out.strongest_neighbours = strongest_neighbours(best);
  VACUFORM_TRY(matrix, couplings_of(best, last.context()));
  out.strongest = strongest_pair(matrix, [](int) { return true; });
  out.k_rms = rms(matrix);
  if (wish.overlap == 0) out.coupled = coupling_warning(coupled_loops(charted.surface(), best, matrix), true);
  std::vector<double> mm;
  for (const Neighbours& n : layout.pairs) {
    mm.push_back(distance(surface, layout, n));
    out.spacing_mm += mm.back() / out.pairs;
  }
  for (const double d : mm) out.spacing_rms_mm += (d - out.spacing_mm) * (d - out.spacing_mm) / out.pairs;
  out.spacing_rms_mm = std::sqrt(out.spacing_rms_mm);
  std::vector<Vector2d> start;
  for (const Centre& c : layout.centres) {
    out.centres.push_back(surface.place(c.point));
    start.push_back(charted.on_chart(c.point.triangle) ? charted.chart(c.point) : c.drawn);
  }
  out.drawing = with_places(charted, layout, metric_mds(start, layout.pairs, mm));
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  return out;
}

std::string svg_of_rings(const Drawing& drawing, const std::string& title) {
  const std::string w = decimal(drawing.size_mm.x(), 3), h = decimal(drawing.size_mm.y(), 3);
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "mm\" height=\"" + h +
                    "mm\" viewBox=\"" + decimal(-drawing.size_mm.x() / 2, 3) + " " +
                    decimal(-drawing.size_mm.y() / 2, 3) + " " + w + " " + h + "\">\n  <title>" + title +
                    "</title>\n";
  for (const Element& e : drawing.elements) {
    const Shape& shape = e.shapes.front();
    svg += "  <g id=\"" + e.id + "\"";
    if (e.place) svg += " data-place=\"" + numbers_of(*e.place) + "\"";
    svg += "><circle cx=\"" + decimal(e.centre.x(), 4) + "\" cy=\"" + decimal(-e.centre.y(), 4) + "\" r=\"" +
           decimal((shape.curves.front().points.front() - e.centre).norm(), 4) +
           "\" fill=\"none\" stroke=\"#000\" stroke-width=\"" + decimal(shape.stroke->width_mm, 3) +
           "\"/></g>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace vacuform
