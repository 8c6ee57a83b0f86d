#include "worker/inspection/circuit_figures.hpp"

#include <algorithm>
#include <cmath>

#include "worker/inspection/loop_figures.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Between the rows, and beyond them the nearest.
double at_stretch(const std::vector<std::array<double, 2>>& rows, double stretch) {
  if (rows.empty()) return 1;
  const auto after =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row[0] >= stretch; });
  if (after == rows.begin()) return rows.front()[1];
  if (after == rows.end()) return rows.back()[1];
  const auto &a = *(after - 1), &b = *after;
  return a[1] + (stretch - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
}

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
      out.squares +=
          area * formed / width_mm * at_stretch(job_.settings.circuit.ink_stretch, formed / length);
    }
    return out;
  }

 private:
  const Finished& job_;
  const std::array<const InkedSurface*, 2> faces_;
  PlaneLocator locator_;
};

// The sheet where it lies on the head, as a sphere, and how far its ink is above the body.
std::optional<std::pair<FittedSphere, double>> body_of(const Finished& job) {
  std::vector<Vector3d> points;
  double thickness = 0;
  for (const int t : job.flattening.triangles) {
    for (const int v : job.sheet.triangles[t]) points.push_back(job.surface.inked()[v]);
    thickness += job.sheet.element_thickness[t] / static_cast<double>(job.flattening.triangles.size());
  }
  auto sphere = fit_sphere(points);
  if (!sphere) return std::nullopt;
  const bool outside = job.settings.pattern.inked_face == InkedFace::outer;
  const double above = std::max(0.1, (outside ? thickness : 0) + job.settings.scan.clearance_mm);
  sphere->radius_mm -= above;
  if (!(sphere->radius_mm > 1)) return std::nullopt;
  return std::pair(*sphere, above);
}

}  // namespace

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
  const auto body = body_of(job);
  if (out.loops.empty() || !body) return std::nullopt;
  out.above_mm = body->second;
  out.array = array_circuit(out.loops, body->first, body->second, job.settings.circuit);
  return out;
}

}  // namespace vacuform
