#include "worker/coils/array_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "api/base/decimal.hpp"
#include "worker/coils/decoupling.hpp"
#include "worker/coils/metric_mds.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/portion.hpp"
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
  std::vector<Vector3d> border;
  for (const int t : charted.flattening().triangles) {
    const Triangle& c = surface.triangles()[index(t)];
    const auto at = [&](std::size_t k) -> const Vector3d& { return surface.inked()[index(c[k])]; };
    const double third = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 6;
    for (int k = 0; k < 3; ++k) {
      out.area[index(c[index(k)])] += third;
      const int n = surface.across(t, k);
      if (n < 0 || !charted.on_chart(n))
        border.push_back(0.5 * (at(index((k + 1) % 3)) + at(index((k + 2) % 3))));
    }
  }
  out.to_border.assign(out.area.size(), 0);
  for (std::size_t v = 0; v < out.area.size(); ++v) {
    if (out.area[v] == 0) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& b : border) least = std::min(least, (surface.inked()[v] - b).squaredNorm());
    out.to_border[v] = std::sqrt(least);
  }
  return out;
}

SamplingDomain sampling_domain(const InkedSurface& surface, const ChartVertices& vertices, ArrayRegion region,
                               double margin_mm) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t v = 0; v < vertices.area.size(); ++v)
    if (vertices.area[v] > 0)
      low = std::min(low, surface.inked()[v].y()), high = std::max(high, surface.inked()[v].y());
  const double middle = (low + high) / 2;
  SamplingDomain out;
  for (std::size_t v = 0; v < vertices.area.size(); ++v) {
    if (vertices.area[v] == 0 || vertices.to_border[v] < margin_mm) continue;
    const double y = surface.inked()[v].y() - middle;
    if ((region == ArrayRegion::front && y < 0) || (region == ArrayRegion::back && y > 0)) continue;
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
std::vector<Vector3d> lattice(const ChartedSurface& charted, const SamplingDomain& domain, int count) {
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
    out.push_back(charted.surface().place(charted.at_chart(middle + nodes[index(i)]).point));
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

ElementLayout element_layout(const ChartedSurface& charted, const Tessellation& cells) {
  ElementLayout out;
  for (const int v : cells.sites) {
    Centre centre;
    centre.point = point_at(charted, v);
    centre.axis = charted.axis(centre.point.triangle);
    centre.drawn = charted.flattening().chart[index(v)];
    out.centres.push_back(centre);
  }
  // From the back to the front, and from left to right where that is the same.
  std::vector<int> order(cells.sites.size()), place(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const Vector2d &p = out.centres[index(a)].drawn, &q = out.centres[index(b)].drawn;
    return p.y() != q.y() ? p.y() < q.y() : p.x() < q.x();
  });
  std::vector<Centre> sorted;
  for (std::size_t i = 0; i < order.size(); ++i)
    place[index(order[i])] = static_cast<int>(i), sorted.push_back(out.centres[index(order[i])]);
  out.centres = std::move(sorted);
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
  const double k = 0.5522847498307936 * radius, r = radius;
  Curve circle;
  circle.closed = true;
  for (const Vector2d& p : {Vector2d(r, 0), Vector2d(r, k), Vector2d(k, r), Vector2d(0, r), Vector2d(-k, r),
                            Vector2d(-r, k), Vector2d(-r, 0), Vector2d(-r, -k), Vector2d(-k, -r),
                            Vector2d(0, -r), Vector2d(k, -r), Vector2d(r, -k), Vector2d(r, 0)})
    circle.points.push_back(centre + p);
  Shape shape;
  shape.curves.push_back(std::move(circle));
  shape.stroke = Stroke{};
  shape.stroke->width_mm = loop_trace_mm;
  return {id, centre, {shape}};
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
                             const LayoutSettings& wish, double extra_mm, bool settle,
                             const Context& context) {
  const InkedSurface& surface = charted.surface();
  VACUFORM_TRY(where, domain_for(charted, vertices, wish, extra_mm));
  const Tessellation cells =
      tessellate(surface, where.vertices, where.areas, lattice(charted, where, wish.count), settle);
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
  // Where the centres have moved, others may be neighbours. Where no distances are equal, least squares may fold the array
  // over itself: then it stays as the cells are.
  constexpr int rounds = 4;
  constexpr double least_apart = 0.8;
  for (int round = 0; round < rounds; ++round) {
    for (Neighbours& n : layout.pairs) n.drawn_mm = ratio * diameter;
    const std::vector<Centre> before = layout.centres;
    VACUFORM_CHECK(multilaterate(charted, layout.centres, layout.pairs, context));
    for (Centre& c : layout.centres) c.moved.setZero();
    if (nearest_two(surface, layout) < least_apart * ratio * diameter) {
      layout.centres = before;
      break;
    }
    if (!find_pairs(surface, layout, ratio * diameter)) break;
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

double worst_coupling(const Trial& trial) {
  const auto strongest = strongest_neighbours(trial);
  return strongest ? std::abs(strongest->k) : 0;
}

Result<std::optional<StrongestPair>> strongest_of_all(const Trial& trial, const Context& context) {
  std::vector<InductiveLoop> loops;
  for (const LaidCoil& coil : trial.laid) loops.push_back({coil.element.loop, coil.self_nh});
  VACUFORM_TRY(matrix, coupling_matrix(loops, Stage::printing, 0, context));
  return strongest_pair(matrix, [](int) { return true; });
}

// Decouples the loops. Loops that were no neighbours may then have come so near that they overlap: they count, too.
Result<void> decouple_all(const ChartedSurface& charted, const LayoutSettings& wish,
                          const CoilSettings& coils, Trial& trial, const Context& context) {
  const double spacing = 2 * ratio_of(wish) * trial.layout.elements.front().outline.radius_mm;
  constexpr int most_rounds = 3;
  for (int round = 0; round < most_rounds; ++round) {
    VACUFORM_CHECK(decouple(charted, trial.layout, trial.laid, coils.size_limit, context));
    if (!find_pairs(charted.surface(), trial.layout, spacing)) break;
  }
  return {};
}

// The best of several ways to spread the loops: the fewest loops off the head, then the least coupling of neighbours. Each
// way is farther from the border than the one before; a given size is laid as the lattice is and as the region asks in turn.
Result<Trial> best_of(const ChartedSurface& charted, const ChartVertices& vertices,
                      const LayoutSettings& wish, const CoilSettings& coils, const Context& context) {
  constexpr double farther_mm = 2.5;
  const bool fitted = wish.diameter_mm == 0;
  const int most_ways = fitted ? 8 : 4;
  constexpr int most_decoupled = 5;
  constexpr double required_k = 0.01;
  std::optional<Trial> best, nearest;  // decoupled; with the fewest loops off the head before that
  int decoupled = 0;
  for (int way = 0; way < most_ways && decoupled < most_decoupled; ++way) {
    const Portion portion(context, Stage::printing, static_cast<double>(way) / most_ways,
                          (way + 1.0) / most_ways);
    const bool settle = fitted || way % 2 == 1;
    auto layout = spread(charted, vertices, wish, way * farther_mm, settle, portion.context());
    if (!layout && layout.error().code != Code::cancelled && way > 0) break;  // no room for that
    VACUFORM_CHECK(layout);
    layout->keep = coils.keep;
    VACUFORM_TRY(laid, lay_coils(charted, *layout, portion.context()));
    Trial trial{*std::move(layout), std::move(laid)};
    const int off = off_head(trial.laid);
    if (!nearest || off <= off_head(nearest->laid)) nearest = trial;
    if (off > 0) continue;
    if (wish.overlap > 0) return trial;
    VACUFORM_CHECK(decouple_all(charted, wish, coils, trial, portion.context()));
    ++decoupled;
    const auto rank = [](const Trial& of) { return std::pair(off_head(of.laid), worst_coupling(of)); };
    if (!best || rank(trial) < rank(*best)) best = std::move(trial);
    if (off_head(best->laid) == 0 && worst_coupling(*best) < required_k) break;
  }
  if (best) return *std::move(best);
  if (wish.overlap == 0) VACUFORM_CHECK(decouple_all(charted, wish, coils, *nearest, context));
  return *std::move(nearest);
}

// The picture, shifted loop by loop until the least squares of the drawn distances (spacing.hpp) put each centre where
// the layout has it; the best one met.
Result<Drawing> picture_that_lands(const ChartedSurface& charted, const ElementLayout& layout,
                                   std::vector<Vector2d> picture, const Context& context) {
  const InkedSurface& surface = charted.surface();
  constexpr int rounds = 12;
  constexpr double share = 0.7;
  Drawing best;
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    const Drawing drawing = drawing_of(layout, picture);
    ElementLayout landed = lay_by_chart(charted, drawing, {});
    if (landed.centres.size() != picture.size()) break;  // some have left the chart
    VACUFORM_CHECK(multilaterate(charted, landed.centres, landed.pairs, context));
    double off = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      const Vector2d is = charted.chart(landed.centres[i].point),
                     wanted = charted.chart(layout.centres[i].point);
      off += (surface.place(landed.centres[i].point) - surface.place(layout.centres[i].point)).squaredNorm();
      if (is.allFinite() && wanted.allFinite()) picture[i] += share * (wanted - is);
    }
    if (off < least) least = off, best = drawing;
  }
  return best.elements.empty() ? drawing_of(layout, picture) : best;
}

}  // namespace

Result<Array> lay_out_array(const ChartedSurface& charted, const LayoutSettings& wish,
                            const CoilSettings& coils, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  const Portion first(context, Stage::printing, 0, 0.8), last(context, Stage::printing, 0.8, 1);
  const InkedSurface& surface = charted.surface();
  const ChartVertices vertices = chart_vertices(charted);
  VACUFORM_TRY(best, best_of(charted, vertices, wish, coils, first.context()));
  const auto& [layout, laid] = best;

  Array out;
  out.diameter_mm = 2 * layout.elements.front().outline.radius_mm;
  out.pairs = static_cast<int>(layout.pairs.size());
  out.off_head = off_head(laid);
  out.strongest_neighbours = strongest_neighbours(best);
  VACUFORM_TRY(strongest, strongest_of_all(best, last.context()));
  out.strongest = strongest;
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
  VACUFORM_TRY(drawing,
               picture_that_lands(charted, layout, metric_mds(start, layout.pairs, mm), last.context()));
  out.drawing = std::move(drawing);
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
    svg += "  <g id=\"" + e.id + "\"><circle cx=\"" + decimal(e.centre.x(), 4) + "\" cy=\"" +
           decimal(-e.centre.y(), 4) + "\" r=\"" +
           decimal((shape.curves.front().points.front() - e.centre).norm(), 4) +
           "\" fill=\"none\" stroke=\"#000\" stroke-width=\"" + decimal(shape.stroke->width_mm, 3) +
           "\"/></g>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace vacuform
