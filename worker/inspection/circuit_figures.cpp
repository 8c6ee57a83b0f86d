#include "worker/inspection/circuit_figures.hpp"

#include <algorithm>
#include <cmath>

#include "worker/electrical/sheet_dielectric.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Loops {
 public:
  explicit Loops(const Finished& job)
      : job_(job), faces_{&job.surface, job.reverse}, locator_(job.sheet.triangles, job.sheet.rest) {}

  LoopOnPart on_part(int element, const Curve& loop, double width_mm, double inductance_nh) const {
    LoopOnPart out;
    out.inductance_nh = inductance_nh;
    const auto gaps = std::count_if(job_.build->gaps.begin(), job_.build->gaps.end(),
                                    [&](const LoopGap& gap) { return gap.coil == element; });
    out.gaps = std::max(1, static_cast<int>(gaps));
    if (std::any_of(job_.build->gaps.begin(), job_.build->gaps.end(),
                    [&](const LoopGap& gap) { return gap.coil == element && gap.plate; }))
      out.loss_tangent = sheet_dielectric(job_.settings.sheet).loss_tangent;
    constexpr double piece_mm = 1;
    std::vector<Vector2d> flat = densified(loop_line(loop, 0).points, piece_mm, true);
    if (signed_area(flat) < 0) std::reverse(flat.begin(), flat.end());
    std::vector<int> triangles;
    for (const Vector2d& p : flat) {
      const auto at = locator_.find(p);
      if (!at) return {};
      out.line.push_back(faces_[index(job_.build->faces[index(element)])]->place(*at));
      triangles.push_back(at->triangle);
    }
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const std::size_t next = (i + 1) % flat.size();
      const double formed = (out.line[next] - out.line[i]).norm(), length = (flat[next] - flat[i]).norm();
      if (!(length > 0)) continue;
      const double area =
          job_.settings.sheet.thickness_mm / job_.sheet.element_thickness[index(triangles[i])];
      out.squares += area * formed / width_mm * ink_ratio(job_.settings.circuit.ink_stretch, formed / length);
    }
    if (!job_.build->widened.empty()) out.squares *= job_.build->widened[index(element)].resistance;
    return out;
  }

 private:
  const Finished& job_;
  const std::array<const InkedSurface*, 2> faces_;
  PlaneLocator locator_;
};

}  // namespace

std::optional<BodyBelow> body_below(const FormedSheet& sheet, const InkedSurface& surface,
                                    const Flattening& flattening, const Settings& settings) {
  std::vector<Vector3d> points;
  double thickness = 0;
  for (const int t : flattening.triangles) {
    for (const int v : sheet.triangles[t]) points.push_back(surface.inked()[v]);
    thickness += sheet.element_thickness[t] / static_cast<double>(flattening.triangles.size());
  }
  auto sphere = fit_sphere(points);
  if (!sphere) return std::nullopt;
  const bool outside = settings.pattern.inked_face == InkedFace::outer;
  const double above = std::max(0.1, (outside ? thickness : 0) + settings.scan.clearance_mm);
  sphere->radius_mm -= above;
  if (!(sphere->radius_mm > 1)) return std::nullopt;
  return BodyBelow{*sphere, above};
}

std::optional<CircuitFigures> circuit_figures(const Finished& job, const VectorPrint& vectors) {
  if (!job.figures.measured || !job.build) return std::nullopt;
  const Loops loops(job);
  const CoilTable& table = job.figures.measured->coils;
  CircuitFigures out;
  for (std::size_t c = 0; c < table.coils.size(); ++c) {
    const Coil& coil = table.coils[c];
    if (!coil.with || !coil.with->on_head || !coil.with->inductance_nh) continue;
    for (std::size_t e = 0; e < vectors.elements.size(); ++e) {
      if (vectors.elements[e].id != coil.id || !vectors.elements[e].loop) continue;
      const double width = job.placed->elements[e].loop->width_mm * job.settings.pattern.scale;
      LoopOnPart loop =
          loops.on_part(static_cast<int>(e), *vectors.elements[e].loop, width, *coil.with->inductance_nh);
      if (loop.line.empty()) continue;
      out.loops.push_back(std::move(loop));
      out.elements.push_back(static_cast<int>(e));
      out.coils.push_back(static_cast<int>(c));
    }
  }
  const auto body = body_below(job.sheet, job.surface, job.flattening, job.settings);
  if (out.loops.empty() || !body) return std::nullopt;
  out.above_mm = body->above_mm;
  out.array = array_circuit(out.loops, *body, job.settings.circuit);
  return out;
}

}  // namespace vacuform
