#include "worker/inspection/coil_figures.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "worker/coils/inductance.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double near_miss = 1.15;  // of the sum of the radii: loops this close are neighbours

double area_of(const std::vector<Vector2d>& line) { return std::abs(signed_area(line)); }

// Counter-clockwise on the sheet, so that the sign of a coupling is that of the overlap and does not depend on how a
// loop was drawn.
std::vector<Vector2d> counter_clockwise(std::vector<Vector2d> line) {
  if (signed_area(line) < 0) std::reverse(line.begin(), line.end());
  return line;
}

Vector2d middle_of(const std::vector<Vector2d>& line) {
  Vector2d sum(0, 0);
  for (const Vector2d& p : line) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(1, line.size()));
}

// The printed loop of the kind that was drawn: the rest of a loop that the border cuts is not a loop with a gap.
std::vector<Vector2d> printed_loop(const VectorPrint& print, const std::string& id, const DrawnLoop& drawn) {
  std::optional<DrawnLoop> out;
  const auto take = [&](std::optional<DrawnLoop> loop) {
    if (loop && loop->lines == drawn.lines && (!out || loop->area_mm2 > out->area_mm2)) out = std::move(loop);
  };
  for (const PrintedElement& element : print.elements) {
    if (element.id != id) continue;
    std::vector<LoopLine> lines;
    for (const Centreline& line : element.centrelines) lines.push_back(loop_line(line.curve, line.width_mm));
    take(drawn.kind == DrawnLoop::Kind::gapped_line ? gapped_line(lines) : closed_line(lines));
  }
  return out ? std::move(out->line) : std::vector<Vector2d>();
}

// About 120 points of the outline.
std::vector<Vector3d> conductor(const LoopFigures& loop) {
  const std::size_t stride = std::max<std::size_t>(1, loop.outline.size() / 120);
  std::vector<Vector3d> line;
  for (std::size_t i = 0; i < loop.outline.size(); i += stride) line.push_back(loop.outline[i]);
  return line;
}

CoilFigures figures_of(const LoopFigures& loop, const ShapeDistance& shape, const CoilLoops& coil) {
  CoilFigures out;
  out.on_head = loop.on_head;
  out.centre = loop.centre;
  out.diameter_mm = loop.diameter_mm;
  out.diameter_error = loop.diameter_mm / (coil.drawn_diameter_mm * coil.size) - 1;
  out.circularity = loop.circularity;
  out.shape = shape;
  out.shape_error = shape.largest_mm / (coil.drawn_diameter_mm * coil.size);
  out.area_mm2 = loop.area_mm2;
  out.area_error = loop.area_mm2 / (coil.drawn_area_mm2 * coil.size * coil.size) - 1;
  out.worst_stretch = loop.worst_stretch;
  if (coil.trace_mm > 0) out.inductance_nh = self_inductance_nh(conductor(loop), coil.trace_mm);
  return out;
}

// All pairs of coils that have figures for one way of printing.
Result<CouplingMatrix> couplings(const CoilTable& table, const std::vector<std::optional<LoopFigures>>& found,
                                 std::optional<CoilFigures> Coil::*way, std::size_t offset,
                                 const Context& context) {
  std::vector<InductiveLoop> loops(table.coils.size());
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (const auto& figures = table.coils[i].*way; figures && figures->inductance_nh)
      loops[i] = {conductor(*found[2 * i + offset]), *figures->inductance_nh};
  return coupling_matrix(loops, Stage::inspection, 1, context);
}

CoilSummary summary_of(const CoilTable& table, std::optional<CoilFigures> Coil::*way,
                       std::optional<PairFigures> CoilPair::*pair_way) {
  CoilSummary out;
  const auto counts = [&](int i) {
    const auto& figures = table.coils[static_cast<std::size_t>(i)].*way;
    return figures && figures->on_head;
  };
  const auto take = [](double value, double& sum, double& worst) {
    sum += std::abs(value), worst = std::max(worst, std::abs(value));
  };
  for (int i = 0; i < static_cast<int>(table.coils.size()); ++i) {
    if (!counts(i)) continue;
    const CoilFigures& f = *(table.coils[static_cast<std::size_t>(i)].*way);
    const Coil& coil = table.coils[static_cast<std::size_t>(i)];
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
    if (!counts(pair.a) || !counts(pair.b) || !(pair.*pair_way)) continue;
    const PairFigures& f = *(pair.*pair_way);
    ++out.pairs;
    squares += (f.mm - pair.drawn_mm) * (f.mm - pair.drawn_mm);
    out.worst_spacing_mm = std::max(out.worst_spacing_mm, std::abs(f.mm - pair.drawn_mm));
    if (f.k && (!out.strongest_neighbours || std::abs(*f.k) > std::abs(out.strongest_neighbours->k)))
      out.strongest_neighbours = CoupledPair{pair.a, pair.b, f.mm, *f.k};
  }
  out.spacing_rms_mm = std::sqrt(squares / std::max(1, out.pairs));
  return out;
}

}  // namespace

std::vector<CoilLoops> coil_loops(const Drawing& drawing, const Placement& placement,
                                  const VectorPrint& print, const Flattening& flattening,
                                  const Alignment& alignment) {
  const auto plain = [&](const Vector2d& uv) -> Vector2d {
    return flattening.top_rest + alignment.chart(uv);
  };
  std::vector<CoilLoops> coils;
  for (std::size_t i = 0; i < drawing.elements.size(); ++i) {
    const Element& element = drawing.elements[i];
    const auto drawn = element.id.empty() ? std::nullopt : drawn_loop(element);
    if (!drawn) continue;
    const PlaneLoopFigures flat = measure_plane_loop(drawn->line);
    CoilLoops coil;
    coil.id = element.id;
    coil.drawn_centre = alignment.scale * flat.centre;
    coil.drawn_diameter_mm = alignment.scale * flat.diameter_mm;
    coil.drawn_area_mm2 = alignment.scale * alignment.scale * flat.area_mm2;
    coil.drawn_circularity = flat.circularity;
    for (const Vector2d& p : counter_clockwise(drawn->line)) coil.drawn.push_back(alignment.scale * p);
    coil.with = {printed_loop(print, element.id, *drawn), {0, 0}};
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
    // The rest of a coil that runs off its patch may be a smaller loop.
    const double expected = area_of(coil.without.line) * coil.size * coil.size;
    if (area_of(coil.with.line) < 0.2 * expected) coil.with.line.clear();
    coils.push_back(std::move(coil));
  }
  return coils;
}

std::vector<NeighbourLoops> neighbours(const std::vector<CoilLoops>& coils, const Placement& placement,
                                       const Drawing& drawing) {
  std::map<std::pair<int, int>, std::optional<double>> pairs;  // with the coupling before decoupling
  const auto coil_of = [&](int placed) {
    const auto& id =
        drawing
            .elements[static_cast<std::size_t>(placement.elements[static_cast<std::size_t>(placed)].element)]
            .id;
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
        const auto &p = coils[static_cast<std::size_t>(a)], &q = coils[static_cast<std::size_t>(b)];
        const double radii = (p.drawn_diameter_mm + q.drawn_diameter_mm) / 2;
        if ((p.drawn_centre - q.drawn_centre).norm() <= near_miss * radii)
          pairs.emplace(std::pair(a, b), std::nullopt);
      }
  std::vector<NeighbourLoops> out;
  for (const auto& [pair, k_before] : pairs) out.push_back({pair.first, pair.second, k_before});
  return out;
}

Result<CoilTable> measure_coils(const MeasuredSheet& measured, const std::vector<CoilLoops>& loops,
                                const std::vector<NeighbourLoops>& pairs, std::optional<CoilKeep> keep,
                                const Context& context) {
  // Two loops a coil, then two ways a pair, a few at a time so that a cancellation takes effect soon.
  const int coils = static_cast<int>(loops.size()), all = 2 * (coils + static_cast<int>(pairs.size()));
  std::vector<std::optional<LoopFigures>> found(static_cast<std::size_t>(2 * coils));
  std::vector<ShapeDistance> shapes(found.size());
  std::vector<double> distances(2 * pairs.size(), std::nan(""));
  const auto work = [&](int item) {
    const bool with = item % 2 == 0;
    if (item < 2 * coils) {
      const CoilLoops& coil = loops[static_cast<std::size_t>(item / 2)];
      const FlatLoop& loop = with ? coil.with : coil.without;
      if (loop.line.empty()) return;
      auto& figures = found[static_cast<std::size_t>(item)] =
          measure_loop(measured, loop.line, loop.near, keep.value_or(CoilKeep::area));
      if (!figures) return;
      std::vector<Vector2d> drawn = coil.drawn;
      for (Vector2d& p : drawn) p *= with ? coil.size : 1;  // the plain drawing has no decoupling
      shapes[static_cast<std::size_t>(item)] = shape_distance(figures->shape, drawn);
      return;
    }
    const auto pair = static_cast<std::size_t>(item / 2 - coils);
    const auto of = [&](int coil) -> const auto& { return found[index(2 * coil + item % 2)]; };
    const auto &a = of(pairs[pair].a), &b = of(pairs[pair].b);
    if (a && b)
      distances[static_cast<std::size_t>(item - 2 * coils)] =
          geodesic_distance(measured, a->centre_rest, b->centre_rest);
  };
  constexpr int batch = 4;
  for (int begin = 0; begin < all;) {
    VACUFORM_CHECK(context.step(Stage::inspection, static_cast<double>(begin) / all));
    // Pairs need the coils' centres.
    const int end = std::min(begin + batch, begin < 2 * coils ? 2 * coils : all);
    in_parallel(begin, end, [&](int first, int last) {
      for (int item = first; item < last; ++item) work(item);
    });
    begin = end;
  }

  CoilTable table;
  table.keep = keep;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const CoilLoops& coil = loops[i];
    Coil& row = table.coils.emplace_back();
    row = {coil.id,   coil.drawn_diameter_mm, coil.drawn_area_mm2, coil.drawn_circularity,
           coil.size, coil.moved_mm,          coil.smooth,         {},
           {}};
    if (found[2 * i]) row.with = figures_of(*found[2 * i], shapes[2 * i], coil);
    if (found[2 * i + 1]) {
      CoilLoops as_drawn = coil;  // the plain drawing has no decoupling
      as_drawn.size = 1;
      row.without = figures_of(*found[2 * i + 1], shapes[2 * i + 1], as_drawn);
    }
  }
  if (coils <= most_coupled_coils) {
    VACUFORM_TRY(with, couplings(table, found, &Coil::with, 0, context));
    VACUFORM_TRY(without, couplings(table, found, &Coil::without, 1, context));
    table.k_with = std::move(with), table.k_without = std::move(without);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto a = static_cast<std::size_t>(pairs[i].a), b = static_cast<std::size_t>(pairs[i].b);
    CoilPair& row = table.pairs.emplace_back();
    row.a = pairs[i].a, row.b = pairs[i].b;
    row.k_before = pairs[i].k_before;
    row.drawn_mm = (loops[a].drawn_centre - loops[b].drawn_centre).norm();
    row.drawn_overlap_mm = (loops[a].drawn_diameter_mm + loops[b].drawn_diameter_mm) / 2 - row.drawn_mm;
    for (const std::size_t way : {0, 1}) {
      const double mm = distances[2 * i + way];
      if (!std::isfinite(mm)) continue;
      const LoopFigures &one = *found[2 * a + way], &other = *found[2 * b + way];
      PairFigures figures{mm, (one.diameter_mm + other.diameter_mm) / 2 - mm, {}};
      const CouplingMatrix& k = way == 0 ? table.k_with : table.k_without;
      if (loops[a].trace_mm > 0 && loops[b].trace_mm > 0)
        figures.k = k.count() > 0
                        ? k(pairs[i].a, pairs[i].b)
                        : coupling(conductor(one), loops[a].trace_mm, conductor(other), loops[b].trace_mm);
      (way == 0 ? row.with : row.without) = figures;
    }
  }
  table.with = summary_of(table, &Coil::with, &CoilPair::with);
  table.without = summary_of(table, &Coil::without, &CoilPair::without);
  for (const std::size_t way : {0, 1}) {
    const auto on_head = [&](int i) {
      const auto& figures =
          table.coils[static_cast<std::size_t>(i)].*(way == 0 ? &Coil::with : &Coil::without);
      return figures && figures->on_head;
    };
    const auto strongest = strongest_pair(way == 0 ? table.k_with : table.k_without, on_head);
    if (!strongest) continue;
    const auto centre = [&](int i) { return found[2 * static_cast<std::size_t>(i) + way]->centre_rest; };
    (way == 0 ? table.with : table.without).strongest =
        CoupledPair{strongest->a, strongest->b,
                    geodesic_distance(measured, centre(strongest->a), centre(strongest->b)), strongest->k};
  }
  return table;
}

}  // namespace vacuform
