#include "worker/inspection/figures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/inspection/inspection.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

WayFigures way_figures(const Finished& job, const CornersUv& uv) {
  const Flattening& f = job.flattening;
  WayFigures out;
  out.triangles = distortion_values(job.surface, f.triangles, uv);
  out.chart = distortion(out.triangles);
  if (f.favoured.empty()) return out;
  for (const bool favoured : {true, false}) {
    std::vector<int> part;
    CornersUv of_part;
    for (std::size_t i = 0; i < f.triangles.size(); ++i)
      if ((f.favoured[i] != 0) == favoured) part.push_back(f.triangles[i]), of_part.push_back(uv[i]);
    (favoured ? out.favoured : out.rest) = distortion(distortion_values(job.surface, part, of_part));
  }
  return out;
}

// From the flat sheet to the inked surface.
void add_vertex_figures(const Finished& job, Figures& out) {
  const std::size_t count = job.sheet.formed.size();
  std::vector<double> weight(count, 0);
  out.shape.assign(count, 0);
  out.area.assign(count, 0);
  for (const int t : job.flattening.triangles) {
    std::array<Eigen::Vector2d, 3> from;
    std::array<Eigen::Vector3d, 3> to;
    const auto& corners = job.sheet.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] = job.sheet.rest[corners[k]];
      to[k] = job.surface.inked()[corners[k]];
    }
    const double formed = (to[1] - to[0]).cross(to[2] - to[0]).norm() / 2;
    const SingularValues s = singular_values(from, to);
    const double shape = s.largest / s.smallest, ratio = s.largest * s.smallest;
    if (!std::isfinite(shape) || !std::isfinite(1 / ratio)) continue;
    for (const int corner : corners) {
      const auto v = static_cast<std::size_t>(corner);
      out.shape[v] += formed * shape;
      out.area[v] += formed * std::max(ratio, 1 / ratio);
      weight[v] += formed;
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    out.shape[v] = weight[v] > 0 ? out.shape[v] / weight[v] : NAN;
    out.area[v] = weight[v] > 0 ? out.area[v] / weight[v] : NAN;
  }
}

std::vector<double> mold_distances(const Finished& job) {
  const MoldDistance to_mold(job.mold.mesh);
  std::vector<double> out(job.sheet.formed.size());
  in_parallel(0, static_cast<int>(out.size()), [&](int first, int last) {
    int nearest = -1;
    for (auto v = static_cast<std::size_t>(first); v < static_cast<std::size_t>(last); ++v)
      out[v] = to_mold(job.sheet.formed[v], nearest);
  });
  return out;
}

void add_least_thickness(const Finished& job, Figures& out) {
  const double spacing = grid_spacing_mm(job.settings);
  const auto least = [&](const std::vector<int>& triangles) {
    double whole = INFINITY, any = INFINITY;
    for (const int t : triangles) {
      const auto& c = job.sheet.triangles[t];
      const auto rest = [&](std::size_t k) { return job.sheet.rest[c[k]]; };
      const double thickness = job.sheet.element_thickness[t];
      any = std::min(any, thickness);
      if (std::abs(cross(rest(1) - rest(0), rest(2) - rest(0))) / 2 >= spacing * spacing / 4)
        whole = std::min(whole, thickness);
    }
    return std::isfinite(whole) ? whole : any;
  };
  std::vector<int> all(job.sheet.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  out.least_thickness = least(all);
  out.chart_least_thickness = least(job.flattening.triangles);
}

}  // namespace

void add_chart_figures(Finished& job) {
  Figures& f = job.figures;
  together([&] { f.mold_distance = mold_distances(job); },
           [&] { f.without = way_figures(job, corners_of(job.sheet, job.flattening, job.sheet.rest)); },
           [&] { f.with = way_figures(job, corners_of(job.print, job.alignment)); },
           [&] {
             add_vertex_figures(job, f);
             add_least_thickness(job, f);
           });
}

}  // namespace vacuform
