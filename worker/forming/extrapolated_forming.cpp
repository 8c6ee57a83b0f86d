// A fine sheet from two coarse ones, for a first look.
//
// The error of a formed membrane shrinks with the square of the grid's spacing wherever the sheet lies on the mold
// (bench_exact). So two formings, on grids of four and two times the spacing, tell what a finer one would give
// (Richardson's extrapolation): where both touch the mold, a point of the sheet moves on by a share of the way between
// them, elsewhere it stays as on the finer of the two. The result is interpolated to the grid without kinks, and what
// touches the mold is put back on it.
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/forming/interpolation.hpp"
#include "worker/forming/process.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr double most_off_mm = 0.5;  // from the mold: a sheet that bridges a groove is not pushed into it

// Mean spacing of the grid inside the window.
double spacing_of(const Process& process) {
  const auto inside = [](const std::vector<double>& lines, double length) {
    const auto n = std::count_if(lines.begin(), lines.end(),
                                 [&](double at) { return std::abs(at) <= length / 2 + 1e-9; });
    return length / static_cast<double>(std::max<std::ptrdiff_t>(1, n - 1));
  };
  const MachineSettings& m = process.machine;
  const double height = m.window == WindowShape::circle ? m.window_width_mm : m.window_height_mm;
  return std::sqrt(inside(process.grid.columns, m.window_width_mm) * inside(process.grid.rows, height));
}

// Moves what touches the mold on both sheets to where a finer grid would have it; returns how far.
std::vector<double> extrapolate(const Process& coarse_process, const SheetState& coarse,
                                const Process& fine_process, SheetState& fine) {
  const double ratio = spacing_of(coarse_process) / spacing_of(fine_process);
  const double share = 1 / (ratio * ratio - 1);
  const SmoothInterpolation to_fine(coarse_process.grid, coarse.rest, fine.rest);
  const Points there = to_fine(coarse.x);
  std::vector<double> moved;
  for (std::size_t i = 0; i < fine.rest.size(); ++i) {
    const auto corners = to_fine.corners(i);
    if (fine.contact[i] != Contact::mold || std::any_of(corners.begin(), corners.end(), [&](int v) {
          return coarse.contact[v] != Contact::mold;
        }))
      continue;
    const auto at = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d step = share * (fine.x.col(at) - there.col(at));
    fine.x.col(at) += step;
    moved.push_back(step.norm());
  }
  return moved;
}

// Upward unit normals of the vertices.
Points normals_of(const SheetGrid& grid, const Points& x) {
  Points normals = Points::Zero(3, x.cols());
  for (const Triangle& t : grid.triangles) {
    const Eigen::Vector3d a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]), n = (b - a).cross(c - a);
    for (const int v : t) normals.col(v) += n;
  }
  return normals.colwise().normalized();
}

// Brings the sheet of another grid to this one.
void take_over(const Process& process, SheetState& state, const Process& from_process,
               const SheetState& from) {
  const SmoothInterpolation interpolation(from_process.grid, from.rest, state.rest);
  state.x = interpolation(from.x);
  const Points normals = normals_of(process.grid, state.x);
  const auto take = [&](std::size_t i) {
    auto place = state.x.col(static_cast<Eigen::Index>(i));
    const auto corners = interpolation.corners(i);
    const auto shares = interpolation.shares(i);
    const auto nearest = std::max_element(shares.begin(), shares.end()) - shares.begin();
    state.folded[i] = from.folded[corners[nearest]];
    if (state.contact[i] == Contact::clamp) {  // by the frame, which holds all its vertices at one height
      place << state.rest[i], from.x(2, 0);
      return;
    }
    const auto all_touch = [&](Contact with) {
      return std::all_of(corners.begin(), corners.end(), [&](int v) { return from.contact[v] == with; });
    };
    Contact& contact = state.contact[i];
    if (all_touch(Contact::mold)) {
      const Eigen::Vector3d on_mold = process.obstacles.nearest_on_mold(place);
      if ((on_mold - place).norm() <= most_off_mm) place = on_mold, contact = Contact::mold;
    } else if (all_touch(Contact::platform)) {
      place.z() = 0, contact = Contact::platform;
    } else if (all_touch(Contact::clamp)) {
      contact = Contact::clamp;
    }
    if (contact == Contact::free) {  // it may be in something that the coarse sheet passes
      const Eigen::Vector3d outside =
          place + from_process.sheet.resolution_mm * normals.col(static_cast<Eigen::Index>(i));
      if (const auto touch = process.obstacles.first_touch(outside, place))
        place = touch->place, contact = touch->with;
    }
    if (contact == Contact::free) return;
    state.held[i] = 1;
    double weight = 0, time = 0;
    for (std::size_t k = 0; k < 4; ++k)
      if (const double at = from.time[corners[k]]; !std::isnan(at))
        weight += shares[k], time += shares[k] * at;
    if (weight > 0) state.time[i] = time / weight;
  };
  in_parallel(0, static_cast<int>(state.rest.size()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) take(static_cast<std::size_t>(i));
  });
}

}  // namespace

Result<void> form_extrapolated(const Process& process, SheetState& state, const Context& context) {
  const Process coarse_process = process.on_grid(4 * process.sheet.resolution_mm),
                fine_process = process.on_grid(2 * process.sheet.resolution_mm);
  SheetState coarse(coarse_process), fine(fine_process);
  // Both at once: each alone is too small to keep all threads busy. The finer takes longer, so it tells the progress.
  Context unseen([&](Stage, double) {
    if (context.cancelled()) unseen.cancel();
  });
  std::array<Result<void>, 2> outcomes;
  in_parallel(0, 2, [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      outcomes[k] =
          k == 0 ? form_membrane(fine_process, fine, context) : form_membrane(coarse_process, coarse, unseen);
  });
  for (const auto& outcome : outcomes) VACUFORM_CHECK(outcome);
  std::vector<double> moved = extrapolate(coarse_process, coarse, fine_process, fine);
  take_over(process, state, fine_process, fine);
  state.summary = fine.summary;
  state.summary.iterations += coarse.summary.iterations;
  Extrapolation& said = state.summary.extrapolation.emplace();
  said.coarse_mm = coarse_process.sheet.resolution_mm, said.fine_mm = fine_process.sheet.resolution_mm;
  if (moved.empty()) return {};
  std::sort(moved.begin(), moved.end());
  for (const double step : moved) said.mean += step / static_cast<double>(moved.size());
  said.p95 = moved[static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(moved.size()))) - 1];
  said.max = moved.back();
  return {};
}

}  // namespace vacuform
