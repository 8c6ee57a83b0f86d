#include "worker/inspection/coil_figures.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "worker/coils/inductance.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/batches.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double near_miss = 1.15;  // of the sum of the radii: loops this close are neighbours

// Counter-clockwise on the sheet, so that the sign of a coupling is that of the overlap and does not depend on how a
// loop was drawn. A figure of eight runs as it was drawn.
std::vector<Vector2d> counter_clockwise(std::vector<Vector2d> line) {
  if (signed_area(line) < -0.01 * lobes_area(line)) std::reverse(line.begin(), line.end());
  return line;
}

Vector2d middle_of(const std::vector<Vector2d>& line) {
  Vector2d sum(0, 0);
  for (const Vector2d& p : line) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(1, line.size()));
}

// About 120 points of the outline.
std::vector<Vector3d> conductor(const LoopFigures& loop) {
  const std::size_t stride = std::max<std::size_t>(1, loop.outline.size() / 120);
  std::vector<Vector3d> line;
  for (std::size_t i = 0; i < loop.outline.size(); i += stride) line.push_back(loop.outline[i]);
  return line;
}

// The plain drawing has no decoupling.
double size_of(const CoilLoops& coil, Way way) { return way == Way::with ? coil.size : 1; }

CoilFigures figures_of(const LoopFigures& loop, const ShapeDistance& shape, const CoilLoops& coil,
                       double size) {
  CoilFigures out;
  out.on_head = loop.on_head;
  out.centre = loop.centre;
  out.diameter_mm = loop.diameter_mm;
  out.diameter_error = loop.diameter_mm / (coil.drawn_diameter_mm * size) - 1;
  out.circularity = loop.circularity;
  out.shape = shape;
  out.shape_error = shape.largest_mm / (coil.drawn_diameter_mm * size);
  out.area_mm2 = loop.area_mm2;
  out.area_error = loop.area_mm2 / (coil.drawn_area_mm2 * size * size) - 1;
  out.worst_stretch = loop.worst_stretch;
  if (coil.trace_mm > 0) out.inductance_nh = self_inductance_nh(conductor(loop), coil.trace_mm);
  return out;
}

// The loops as they come out one way.
struct FormedLoops {
  std::vector<std::optional<LoopFigures>> loops;
  std::vector<ShapeDistance> shapes;  // of the loops, from what was drawn
  std::vector<double> pairs_mm;       // geodesic distances of the centres; NaN where a loop is missing
};

Result<Both<FormedLoops>> measure_loops(const MeasuredFaces& sheets, const std::vector<CoilLoops>& coils,
                                        const std::vector<NeighbourLoops>& pairs, CoilKeep keep,
                                        const Context& context) {
  Both<FormedLoops> out;
  for (const Way way : both_ways) {
    out[way].loops.resize(coils.size());
    out[way].shapes.resize(coils.size());
    out[way].pairs_mm.resize(pairs.size(), std::nan(""));
  }
  const double all = static_cast<double>(std::max<std::size_t>(1, coils.size() + pairs.size())),
               share = static_cast<double>(coils.size()) / all;
  const SubProgress of_coils(context, {Stage::inspection, 0, share}),
      of_pairs(context, {Stage::inspection, share, 1});
  VACUFORM_CHECK(in_batches(coils.size(), 4, Stage::inspection, of_coils.context(), [&](std::size_t i) {
    for (const Way way : both_ways) {
      const FlatLoop& loop = coils[i][way];
      if (loop.line.empty()) continue;
      const MeasuredSheet& sheet = way == Way::with && coils[i].reverse ? *sheets.reverse : sheets.first;
      auto& figures = out[way].loops[i] = measure_loop(sheet, loop.line, loop.near, keep);
      if (!figures) continue;
      std::vector<Vector2d> drawn = coils[i].drawn;
      for (Vector2d& p : drawn) p *= size_of(coils[i], way);
      out[way].shapes[i] = shape_distance(figures->shape, drawn);
    }
  }));
  VACUFORM_CHECK(in_batches(pairs.size(), 4, Stage::inspection, of_pairs.context(), [&](std::size_t i) {
    for (const Way way : both_ways) {
      const auto &a = out[way].loops[index(pairs[i].a)], &b = out[way].loops[index(pairs[i].b)];
      if (a && b) out[way].pairs_mm[i] = geodesic_distance(sheets.first, a->centre_rest, b->centre_rest);
    }
  }));
  return out;
}

// All pairs of coils that have figures for one way of printing.
Result<CouplingMatrix> couplings(const CoilTable& table, const FormedLoops& formed, Way way,
                                 const Context& context) {
  std::vector<InductiveLoop> loops(table.coils.size());
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (const auto& figures = table.coils[i][way]; figures && figures->inductance_nh)
      loops[i] = {conductor(*formed.loops[i]), *figures->inductance_nh};
  return coupling_matrix(loops, context);
}

Coil coil_row(const CoilLoops& coil, const Both<FormedLoops>& formed, std::size_t i) {
  Coil row;
  row.id = coil.id;
  row.drawn_diameter_mm = coil.drawn_diameter_mm;
  row.drawn_area_mm2 = coil.drawn_area_mm2;
  row.drawn_circularity = coil.drawn_circularity;
  row.size = coil.size;
  row.moved_mm = coil.moved_mm;
  row.smooth = coil.smooth;
  for (const Way way : both_ways)
    if (const auto& loop = formed[way].loops[i])
      row[way] = figures_of(*loop, formed[way].shapes[i], coil, size_of(coil, way));
  return row;
}

// Two neighbours one way; `mm` is the distance of their centres.
PairFigures pair_figures(const NeighbourLoops& pair, const std::vector<CoilLoops>& coils,
                         const FormedLoops& formed, const CouplingMatrix& k, double mm) {
  const auto a = index(pair.a), b = index(pair.b);
  const LoopFigures &one = *formed.loops[a], &other = *formed.loops[b];
  PairFigures figures{mm, (one.diameter_mm + other.diameter_mm) / 2 - mm, {}};
  if (coils[a].trace_mm > 0 && coils[b].trace_mm > 0)
    figures.k = k.count() > 0
                    ? k(pair.a, pair.b)
                    : coupling(conductor(one), coils[a].trace_mm, conductor(other), coils[b].trace_mm);
  return figures;
}

CoilSummary summary_of(const CoilTable& table, const FormedLoops& formed, Way way,
                       const MeasuredSheet& sheet) {
  CoilSummary out;
  const auto counts = [&](int i) {
    const auto& figures = table.coils[index(i)][way];
    return figures && figures->on_head;
  };
  const auto take = [](double value, double& sum, double& worst) {
    sum += std::abs(value), worst = std::max(worst, std::abs(value));
  };
  for (int i = 0; i < static_cast<int>(table.coils.size()); ++i) {
    if (!counts(i)) continue;
    const Coil& coil = table.coils[index(i)];
    const CoilFigures& f = *coil[way];
    ++out.coils;
    out.round += coil.round();
    if (coil.round()) take(f.circularity, out.mean_circularity, out.worst_circularity);
    take(f.shape_error, out.mean_shape_error, out.worst_shape_error);
    take(f.diameter_error, out.mean_diameter_error, out.worst_diameter_error);
    take(f.area_error, out.mean_area_error, out.worst_area_error);
  }
  out.mean_circularity /= std::max(1, out.round);
  for (double* mean : {&out.mean_shape_error, &out.mean_diameter_error, &out.mean_area_error})
    *mean /= std::max(1, out.coils);
  double squares = 0;
  for (const CoilPair& pair : table.pairs) {
    if (!counts(pair.a) || !counts(pair.b) || !pair[way]) continue;
    const PairFigures& f = *pair[way];
    ++out.pairs;
    squares += (f.mm - pair.drawn_mm) * (f.mm - pair.drawn_mm);
    out.worst_spacing_mm = std::max(out.worst_spacing_mm, std::abs(f.mm - pair.drawn_mm));
    if (f.k && (!out.strongest_neighbours || std::abs(*f.k) > std::abs(out.strongest_neighbours->k)))
      out.strongest_neighbours = CoupledPair{pair.a, pair.b, f.mm, *f.k};
  }
  out.spacing_rms_mm = std::sqrt(squares / std::max(1, out.pairs));
  if (const auto strongest = strongest_pair(table.k[way], counts)) {
    const auto centre = [&](int i) { return formed.loops[index(i)]->centre_rest; };
    out.strongest =
        CoupledPair{strongest->a, strongest->b,
                    geodesic_distance(sheet, centre(strongest->a), centre(strongest->b)), strongest->k};
  }
  return out;
}

}  // namespace

std::vector<CoilLoops> coil_loops(const Drawing& drawing, const Placement& placement,
                                  const VectorPrint& print, const Flattening& flattening,
                                  const Alignment& alignment, const std::vector<int>& faces) {
  const auto plain = [&](const Vector2d& uv) -> Vector2d {
    return flattening.top_rest + alignment.chart(uv);
  };
  std::vector<CoilLoops> coils;
  for (std::size_t i = 0; i < drawing.elements.size(); ++i) {
    const Element& element = drawing.elements[i];
    const auto& drawn = element.loop;
    if (!drawn || element.id.empty()) continue;
    const PlaneLoopFigures flat = measure_plane_loop(drawn->line);
    CoilLoops coil;
    coil.id = element.id;
    coil.reverse = i < faces.size() && faces[i] == 1;
    coil.drawn_centre = alignment.scale * flat.centre;
    coil.drawn_diameter_mm = alignment.scale * flat.diameter_mm;
    coil.drawn_area_mm2 = alignment.scale * alignment.scale * flat.area_mm2;
    coil.drawn_circularity = flat.circularity;
    for (const Vector2d& p : counter_clockwise(drawn->line)) coil.drawn.push_back(alignment.scale * p);
    for (const PrintedElement& printed : print.elements)
      if (printed.id == element.id && printed.loop) coil.with.line = loop_line(*printed.loop, 0).points;
    coil.with.near = middle_of(coil.with.line);
    for (const PlacedElement& placed : placement.elements)
      if (placed.element == static_cast<int>(i)) {
        coil.size = placed.size / alignment.scale;
        coil.moved_mm = placed.moved_mm;
        coil.smooth = placed.smooth;
        coil.with.near = placed.centre_rest;
      }
    coil.trace_mm = drawn->width_mm * alignment.scale;
    for (const Vector2d& uv : drawn->line) coil.without.line.push_back(plain(uv));
    coil.without.near = plain(flat.centre);
    coil.with.line = counter_clockwise(std::move(coil.with.line));
    coil.without.line = counter_clockwise(std::move(coil.without.line));
    coils.push_back(std::move(coil));
  }
  return coils;
}

std::vector<NeighbourLoops> neighbours(const std::vector<CoilLoops>& coils, const Placement& placement,
                                       const Drawing& drawing) {
  std::map<std::pair<int, int>, std::optional<double>> pairs;  // with the coupling before decoupling
  const auto coil_of = [&](int placed) {
    const auto& id = drawing.elements[placement.elements[static_cast<std::size_t>(placed)].element].id;
    const auto found =
        std::find_if(coils.begin(), coils.end(), [&](const CoilLoops& coil) { return coil.id == id; });
    return found == coils.end() ? -1 : static_cast<int>(found - coils.begin());
  };
  for (const PlacedPair& pair : placement.pairs) {
    const int a = coil_of(pair.a), b = coil_of(pair.b);
    if (a >= 0 && b >= 0 && a != b) pairs.emplace(std::minmax(a, b), pair.k_before);
  }
  const int count = static_cast<int>(coils.size());
  if (placement.pairs.empty())
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b) {
        const auto &p = coils[a], &q = coils[b];
        const double radii = (p.drawn_diameter_mm + q.drawn_diameter_mm) / 2;
        if ((p.drawn_centre - q.drawn_centre).norm() <= near_miss * radii)
          pairs.emplace(std::pair(a, b), std::nullopt);
      }
  std::vector<NeighbourLoops> out;
  for (const auto& [pair, k_before] : pairs) out.push_back({pair.first, pair.second, k_before});
  return out;
}

Result<CoilTable> measure_coils(const MeasuredFaces& sheet, const std::vector<CoilLoops>& loops,
                                const std::vector<NeighbourLoops>& pairs, std::optional<CoilKeep> keep,
                                const Context& context) {
  VACUFORM_TRY(formed, measure_loops(sheet, loops, pairs, keep.value_or(CoilKeep::area), context));
  CoilTable table;
  table.keep = keep;
  for (std::size_t i = 0; i < loops.size(); ++i) table.coils.push_back(coil_row(loops[i], formed, i));
  if (loops.size() <= most_coupled_coils)
    for (const Way way : both_ways) {
      VACUFORM_TRY(k, couplings(table, formed[way], way, context));
      table.k[way] = std::move(k);
    }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const CoilLoops &a = loops[index(pairs[i].a)], &b = loops[index(pairs[i].b)];
    CoilPair& row = table.pairs.emplace_back();
    row.a = pairs[i].a, row.b = pairs[i].b;
    row.k_before = pairs[i].k_before;
    row.drawn_mm = (a.drawn_centre - b.drawn_centre).norm();
    row.drawn_overlap_mm = (a.drawn_diameter_mm + b.drawn_diameter_mm) / 2 - row.drawn_mm;
    for (const Way way : both_ways)
      if (const double mm = formed[way].pairs_mm[i]; std::isfinite(mm))
        row[way] = pair_figures(pairs[i], loops, formed[way], table.k[way], mm);
  }
  for (const Way way : both_ways) table[way] = summary_of(table, formed[way], way, sheet.first);
  return table;
}

}  // namespace vacuform
