// The region of interest becomes one chart. The chart is flattened and then placed: its origin is the top of the mold
// and it is rotated as little as possible against the sheet, or it is placed by its pins.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "api/base/decimal.hpp"
#include "worker/flattening/embedding.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/flattening/held_points.hpp"
#include "worker/flattening/methods.hpp"
#include "worker/flattening/region.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/numerics/rigid_fit.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

// The chart with its own numbering: sheet vertices in ascending order.
struct Region {
  Chart chart;
  std::vector<int> vertices;           // for each vertex of the chart, its index in the sheet
  std::vector<Eigen::Vector2d> start;  // the flat sheet
};

Region chart_of(const InkedSurface& surface, const std::vector<int>& triangles) {
  Region region;
  std::vector<int> local(surface.rest().size(), -1);
  for (const int k : triangles)
    for (const int v : surface.triangles()[k]) local[v] = 0;
  for (std::size_t v = 0; v < local.size(); ++v) {
    if (local[v] < 0) continue;
    local[v] = static_cast<int>(region.vertices.size());
    region.vertices.push_back(static_cast<int>(v));
    region.chart.inked.push_back(surface.inked()[v]);
    region.start.push_back(surface.rest()[v]);
  }
  for (const int k : triangles) {
    const Triangle& t = surface.triangles()[k];
    region.chart.triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
  }
  region.chart.uv = region.start;
  return region;
}

// A point of the sheet as a point of the chart, to be held at `target`.
ChartPin pin_at(const Spot& spot, const std::vector<int>& triangles, const Eigen::Vector2d& target) {
  const auto at = std::lower_bound(triangles.begin(), triangles.end(), spot.triangle);
  return {static_cast<int>(at - triangles.begin()), spot.corners, target};
}

Result<std::vector<ChartPin>> find_pins(const FormedSheet& sheet, const std::vector<int>& triangles,
                                        const FlatteningSettings& settings) {
  std::vector<ChartPin> pins;
  for (std::size_t i = 0; i < settings.pins.size(); ++i) {
    const auto& [s, t, u, v] = settings.pins[i];
    const Spot spot = spot_at_rest(sheet, triangles, {s, t});
    if (spot.triangle < 0)
      return fail(Code::bad_settings,
                  "the sheet's point of pin " + std::to_string(i + 1) + " is not on the chart",
                  "flattening.pins", "choose points of the sheet that come to lie on the mold");
    pins.push_back(pin_at(spot, triangles, {u, v}));
  }
  return pins;
}

// Rotates the chart by the least squares rotation towards the coordinates of the sheet, weighted by formed area.
void turn_to_sheet(Chart& chart, const std::vector<Eigen::Vector2d>& start) {
  std::vector<double> weight(chart.uv.size(), 0);
  for (const Triangle& t : chart.triangles) {
    const FlatTriangle f = flat_triangle(chart.inked[t[0]], chart.inked[t[1]], chart.inked[t[2]]);
    for (int v : t) weight[v] += f.length * f.height;
  }
  RigidFit fit;
  for (std::size_t i = 0; i < weight.size(); ++i) fit.add(chart.uv[i], start[i], weight[i]);
  const Eigen::Rotation2Dd turn(fit.angle());
  for (auto& u : chart.uv) u = turn * u;
}

// Places the flattening in the plane: by its pins, or with the top at the origin.
class Place {
 public:
  Place(std::vector<Eigen::Vector2d> start, const ChartPin& top, std::vector<ChartPin> pins)
      : start_(std::move(start)), top_(top), pins_(std::move(pins)) {}

  // The start of the method: with two or more pins, the flat sheet moved as near to them as possible.
  void begin(Chart& chart) const {
    if (pins_.size() < 2) return;
    chart.pins = pins_;
    move_onto_pins(chart.uv, chart.triangles, pins_);
  }
  void lay(Chart& chart) const {
    if (pins_.size() < 2) turn_to_sheet(chart, start_);
    move_onto_pins(chart.uv, chart.triangles, pins_.empty() ? std::vector{top_} : pins_);
  }
  // How far the worst pin is from its place, mm.
  double miss(const Chart& chart) const {
    double worst = 0;
    for (const ChartPin& pin : pins_) worst = std::max(worst, (place_of(chart, pin) - pin.target).norm());
    return worst;
  }

 private:
  std::vector<Eigen::Vector2d> start_;
  ChartPin top_;
  std::vector<ChartPin> pins_;
};

Result<FlatteningOutcome> run(Chart& chart, const FlatteningSettings& settings, int seed,
                              const Context& context) {
  switch (settings.method) {
    case FlatteningMethod::arap:
      // Without a weight on areas the hybrid is the conformal map, which needs no iterations.
      return settings.lambda == 0.0 ? flatten_lscm(chart, context)
                                    : flatten_arap(chart, context, settings.lambda);
    case FlatteningMethod::symmetric_dirichlet:
      return flatten_symmetric_dirichlet(chart, context);
    case FlatteningMethod::lscm:
      return flatten_lscm(chart, context);
    case FlatteningMethod::cgal_arap:
      return flatten_cgal_arap(chart, context, settings.lambda);
    case FlatteningMethod::bfs:
      return flatten_breadth_first(chart, seed, context);
  }
  throw std::logic_error("a method of flattening that nobody knows");
}

bool knows_weights(FlatteningMethod method) {
  return method != FlatteningMethod::cgal_arap && method != FlatteningMethod::bfs;
}

bool by_coverage(FlatteningWeights weights) {
  return weights == FlatteningWeights::ink || weights == FlatteningWeights::painted;
}

// Flattens and places the chart, with weights that may depend on the chart itself.
Result<FlatteningOutcome> flatten_weighted(Chart& chart, const FlatteningSettings& settings,
                                           const ChartPin& top, const Place& place,
                                           const InkCoverage& coverage, const Context& context) {
  const bool weighted = settings.weight > 1 && knows_weights(settings.method);
  if (weighted && settings.weights == FlatteningWeights::center)
    chart.weight = center_weights(chart, top.triangle, top.corners, settings.weight);
  const int rounds = weighted && by_coverage(settings.weights) ? 3 : 1;
  FlatteningOutcome total{0, true};
  for (int round = 0; round < rounds; ++round) {
    const SubProgress part(context, {Stage::flattening, double(round) / rounds, double(round + 1) / rounds});
    if (round > 0)
      chart.weight = settings.weights == FlatteningWeights::painted
                         ? painted_weights(chart, coverage, settings.weight)
                         : ink_weights(chart, coverage, settings.weight);
    VACUFORM_TRY(outcome, run(chart, settings, top.triangle, part.context()));
    place.lay(chart);
    total.iterations += outcome.iterations;
    total.converged = outcome.converged;
  }
  return total;
}

// The triangles that the flattening turned over, the largest first.
std::vector<Warning::Mark> flipped_marks(const Chart& chart) {
  std::vector<std::pair<double, std::size_t>> flipped;  // negative size, and index
  for (std::size_t k = 0; k < chart.triangles.size(); ++k) {
    const Triangle& t = chart.triangles[k];
    const Eigen::Vector2d a = chart.uv[t[1]] - chart.uv[t[0]], b = chart.uv[t[2]] - chart.uv[t[0]];
    const double size = std::max((chart.inked[t[1]] - chart.inked[t[0]]).norm(),
                                 (chart.inked[t[2]] - chart.inked[t[0]]).norm());
    if (cross(a, b) <= 0) flipped.emplace_back(-size, k);
  }
  std::sort(flipped.begin(), flipped.end());
  flipped.resize(std::min(flipped.size(), Warning::most_marks));
  std::vector<Warning::Mark> marks;
  for (const auto& [size, k] : flipped) {
    const Triangle& t = chart.triangles[k];
    const Eigen::Vector3d middle = (chart.inked[t[0]] + chart.inked[t[1]] + chart.inked[t[2]]) / 3;
    marks.push_back({{middle.x(), middle.y(), middle.z()}, -size});
  }
  return marks;
}

void warn(Flattening& out, const Chart& chart, bool converged, double pins_missed_by) {
  if (!converged)
    out.warnings.push_back({.code = "flattening-not-converged",
                            .text = "The flattening stopped before it settled",
                            .figure = Warning::Figure{static_cast<double>(out.iterations), "iterations"}});
  if (out.flipped > 0)
    out.warnings.push_back({.code = "flattening-flipped",
                            .text = std::to_string(out.flipped) + " of " +
                                    std::to_string(chart.triangles.size()) +
                                    " triangles of the chart are folded over; the print is wrong there",
                            .marks = flipped_marks(chart),
                            .figure = Warning::Figure{static_cast<double>(out.flipped), "triangles", 0.0}});
  if (out.crossings > 0)
    out.warnings.push_back(
        {.code = "flattening-overlaps",
         .text = "The chart covers places of the drawing twice; what is drawn there is printed twice",
         .figure = Warning::Figure{static_cast<double>(out.crossings), "crossings", 0.0},
         .place = "the border of the chart"});
  constexpr double met_mm = 0.1;
  if (pins_missed_by > met_mm) {
    out.warnings.push_back(
        {.code = "pins-not-met",
         .text = "A pin of the flattening is " + decimal(pins_missed_by, 1) + " mm from its place",
         .figure = Warning::Figure{pins_missed_by, "mm", met_mm},
         .place = "flattening.pins"});
  }
}

// The part that the weights favour, and the energies inside and outside it.
void split(Flattening& out, const Chart& chart, double weight) {
  if (chart.weight.empty()) return;
  out.weight = chart.weight;
  Chart parts[2] = {{{}, chart.inked, chart.uv, {}, {}}, {{}, chart.inked, chart.uv, {}, {}}};
  for (std::size_t k = 0; k < chart.triangles.size(); ++k) {
    out.favoured.push_back(chart.weight[k] >= (1 + weight) / 2);
    parts[out.favoured.back()].triangles.push_back(chart.triangles[k]);
  }
  out.energy_rest = chart_quality(parts[0]).arap;
  out.energy_favoured = chart_quality(parts[1]).arap;
}

}  // namespace

Result<Flattening> flatten(const FormedSheet& sheet, const InkedSurface& surface, const Mold& mold,
                           const FlatteningSettings& settings, const Context& context,
                           const InkCoverage& coverage) {
  if (by_coverage(settings.weights) && !coverage)
    throw std::invalid_argument("weights by ink or paint need to know where it is");
  Flattening out;
  out.triangles = region_of_interest(sheet, surface);
  if (out.triangles.size() < 8)
    return fail(Code::unusable_surface, "hardly any of the sheet lies on the mold", "forming",
                "give a finer sheet.resolution_mm, or a mold that is larger against it");
  auto [chart, vertices, start] = chart_of(surface, out.triangles);

  const Spot spot = spot_below(surface, out.triangles, mold.top);
  if (!spot.exact) {
    const Eigen::Vector3d nearest = surface.place({spot.triangle, spot.corners});
    out.warnings.push_back({.code = "top-off-chart",
                            .text = "The top of the mold is not covered by the chart; the pattern is centred "
                                    "on the nearest point that is",
                            .marks = {{{mold.top.x(), mold.top.y(), mold.top.z()}}},
                            .figure = Warning::Figure{(nearest - mold.top).norm(), "mm", 0.0}});
  }
  const ChartPin top = pin_at(spot, out.triangles, {0, 0});
  VACUFORM_TRY(pins, find_pins(sheet, out.triangles, settings));
  const Place place(start, top, std::move(pins));
  place.begin(chart);
  VACUFORM_TRY(outcome, flatten_weighted(chart, settings, top, place, coverage, context));

  const ChartQuality quality = chart_quality(chart);
  out.iterations = outcome.iterations;
  out.energy = quality.arap;
  out.symmetric_dirichlet = quality.symmetric_dirichlet;
  out.flipped = quality.flipped;
  out.crossings = border_crossings(chart);
  split(out, chart, settings.weight);
  warn(out, chart, outcome.converged, place.miss(chart));

  out.top_rest.setZero();
  for (int e = 0; e < 3; ++e) out.top_rest += spot.corners[e] * sheet.rest[sheet.triangles[spot.triangle][e]];
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  out.chart.assign(sheet.rest.size(), {nan, nan});
  for (std::size_t i = 0; i < vertices.size(); ++i) out.chart[vertices[i]] = chart.uv[i];
  context.report(Stage::flattening, 1);
  return out;
}

}  // namespace vacuform
