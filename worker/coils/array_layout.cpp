#include "worker/coils/array_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/coils/array_relaxation.hpp"
#include "worker/coils/array_starts.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/coils/decoupling.hpp"
#include "worker/coils/metric_mds.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/sorting.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Element ring(const std::string& id, const Vector2d& centre, double radius) {
  Shape shape;
  shape.curves.push_back(circle(centre, radius));
  shape.stroke = Stroke{};
  shape.stroke->width_mm = loop_trace_mm(radius);
  return one_element(id, {std::move(shape)});
}

std::string id_of(std::size_t i) { return "coil-" + std::to_string(i + 1); }

Drawing drawing_of(const ElementLayout& layout, const std::vector<Vector2d>& picture) {
  Drawing out;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double radius = layout.elements[i].size * layout.elements[i].outline.radius_mm;
    out.elements.push_back(ring(id_of(i), picture[i], radius));
    out.size_mm = out.size_mm.cwiseMax(
        2 * (picture[i].cwiseAbs() + Vector2d::Constant(radius + loop_trace_mm(radius))));
  }
  return out;
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

// What decoupling aims at: neighbours below it, and all pairs by rms.
constexpr double little_k = 0.01;
constexpr double likely_rms = 0.01175;     // of an arrangement that decoupling is likely to bring below that
constexpr std::size_t most_decoupled = 3;  // arrangements

// Whether no pair couples by more than it should.
bool is_decoupled(const Trial& trial, const CouplingMatrix& matrix) {
  const auto all = strongest_pair(matrix, [](int) { return true; });
  const auto near = strongest_neighbours(trial);
  return (!all || std::abs(all->k) <= unnulled_k) && (!near || std::abs(near->k) <= little_k);
}

// Loops as evenly spread as the wish's overlap asks; farther and farther from the border until none is off the head.
Result<Trial> overlapping(const ChartedSurface& charted, const LayoutSettings& wish,
                          const CoilSettings& coils, const Context& context) {
  const ArrayStarts starts(charted, wish);
  constexpr double farther_mm = 2.5;
  const bool fitted = wish.diameter_mm == 0;
  const int most_ways = fitted ? 8 : 4;
  std::optional<Trial> best;
  for (int way = 0; way < most_ways; ++way) {
    auto layout = starts.equally_spread(way * farther_mm, fitted || way % 2 == 1, context);
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

// The best arrangement of each size, the largest first, until enough are worth decoupling: from evenly spread centres
// and from hexagonal lattices.
Result<std::vector<Arrangement>> arrangements(const ChartedSurface& charted, const LayoutSettings& wish,
                                              const Context& context) {
  const ArrayStarts from(charted, wish);
  constexpr int most_sizes = 10, many = 32;
  constexpr double smaller = 0.935;
  const int ways = wish.count > many ? 2 : 3, lattice_turns = wish.count > many ? 2 : 5;
  const bool fitted = wish.diameter_mm == 0;
  std::vector<ElementLayout> spreads;
  for (int way = 0; way < ways; ++way) {
    auto layout = from.spread(0, fitted || way > 0, way * M_PI / 3 / ways, context);
    if (!layout && layout.error().code != Code::cancelled && way > 0) break;
    VACUFORM_CHECK(layout);
    spreads.push_back(*std::move(layout));
  }
  const double largest = spreads.front().elements.front().outline.radius_mm;
  const Vector2d middle = from.middle(spreads.front());
  const Relaxation relaxation(charted, from.half());
  const Middle about = relaxation.middle_of(spreads.front().centres, largest);
  std::size_t enough = 0;
  std::vector<Arrangement> out;
  // Of many loops, those that would fill the region never couple little enough.
  const int first_size = fitted && wish.count > many ? 1 : 0;
  for (int size = first_size; size < (fitted ? most_sizes : 1); ++size) {
    VACUFORM_CHECK(context.step(Stage::printing, static_cast<double>(size) / most_sizes));
    const double share = std::pow(smaller, size), radius = share * largest;
    std::vector<std::vector<Centre>> starts;
    for (const ElementLayout& evenly : spreads) starts.push_back(from.drawn_together(evenly, middle, share));
    for (int turn = 0; turn < lattice_turns; ++turn)
      for (int kind = 0; kind < 3; ++kind)
        starts.push_back(from.hexagons(middle, 2 * critical * radius, turn * M_PI / 3 / lattice_turns, kind));
    std::vector<Arrangement> found(starts.size());
    in_parallel(0, static_cast<int>(starts.size()), [&](int first, int last) {
      for (std::size_t i = index(first); i < index(last); ++i)
        found[i] = relaxation.relaxed(std::move(starts[i]), radius, loop_trace_mm(radius), about);
    });
    out.push_back(best_of(found));
    const bool likely = out.back().is_whole() && out.back().rms <= likely_rms;
    if (likely && (++enough == most_decoupled || wish.count > many)) break;
  }
  return out;
}

// Of arrangements of smaller and smaller loops, the first without gaps that decoupling is likely to bring below little_k
// rms, and smaller ones. Few loops have many pairs with one loop between them, which no distance decouples: of these, what
// couples about as little as it can.
std::vector<Arrangement> worth_decoupling(std::vector<Arrangement> found) {
  constexpr double about = 1.12;
  double rms = std::numeric_limits<double>::infinity();
  for (const Arrangement& one : found)
    if (one.is_whole()) rms = std::min(rms, one.rms);
  const double most = rms <= likely_rms ? likely_rms : about * rms;
  std::vector<Arrangement> out;
  for (Arrangement& one : found)
    if (one.is_whole() && one.rms <= most && out.size() < most_decoupled) out.push_back(std::move(one));
  if (out.empty()) out.push_back(best_of(found));
  return out;
}

std::vector<CoupledLoops> coupled_loops(const InkedSurface& surface, const Trial& trial,
                                        const CouplingMatrix& matrix) {
  std::vector<ArrayLoop> loops;
  for (std::size_t i = 0; i < trial.laid.size(); ++i) {
    const LaidElement& e = trial.layout.elements[i];
    loops.push_back({id_of(i), surface.place(trial.layout.centres[i].point), e.size * e.outline.radius_mm,
                     trial.laid[i].element.on_head});
  }
  std::vector<NeighbourLoop> neighbours;
  for (const Neighbours& n : trial.layout.pairs)
    neighbours.push_back({n.a, n.b, coupling(trial.laid[index(n.a)], trial.laid[index(n.b)]),
                          distance(surface, trial.layout, n)});
  return vacuform::coupled_loops(loops, neighbours, matrix);
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
  find_neighbours(charted.surface(), out.layout, 2 * critical * arrangement.radius_mm);
  return out;
}

// The largest loops of which no pair couples by more than it should; else the largest that couple by little_k rms.
Result<Trial> decoupled(const ChartedSurface& charted, const LayoutSettings& wish, const CoilSettings& coils,
                        const Context& context) {
  const SubProgress first(context, {Stage::printing, 0, 0.5}), second(context, {Stage::printing, 0.5, 1});
  VACUFORM_TRY(found, arrangements(charted, wish, first.context()));
  std::optional<Trial> best;
  std::pair<int, bool>
      least;  // loops off the head; whether the rms of k stays above little_k though less was likely
  for (const Arrangement& arrangement : worth_decoupling(std::move(found))) {
    const bool likely = arrangement.rms <= likely_rms;
    VACUFORM_TRY(trial, laid_out(charted, arrangement, coils, second.context()));
    VACUFORM_TRY(matrix, coupling_matrix(trial.laid, second.context()));
    const std::pair<int, bool> faults{off_head(trial.laid), rms(matrix) > little_k && likely};
    const bool good = faults == std::pair(0, false) && is_decoupled(trial, matrix);
    if (!best || good || faults < least) best = std::move(trial), least = faults;
    if (good) break;
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
  VACUFORM_TRY(best, wish.overlap > 0 ? overlapping(charted, wish, coils, first.context())
                                      : decoupled(charted, wish, coils, first.context()));
  const auto& [layout, laid] = best;

  Array out;
  out.diameter_mm = 2 * layout.elements.front().outline.radius_mm;
  out.pairs = static_cast<int>(layout.pairs.size());
  out.off_head = off_head(laid);
  out.covered = ArrayStarts(charted, wish).covered(layout);
  out.strongest_neighbours = strongest_neighbours(best);
  VACUFORM_TRY(matrix, coupling_matrix(laid, last.context()));
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
