// Forming against exact solutions: where the sheet lands, on finer grids and with smaller steps, and the observed order.
//
//   bench_exact [--step MM ...] [GRID_MM ...]       (the default step, and grids of 6 3 1.5 mm, when none is given)
//
// Hemispheres of R = 75 mm under clamp rings of 1.3, 1.5 and 2 R, and a cone of 45 degrees and base radius 75 mm under a
// ring of 1.5, lowered to the platform, then vacuum; grooves of 32 mm width whose walls make 30 and 52.5 degrees with
// the flat sheet, under vacuum alone. Neo-Hookean. The error of a vertex on the mold is the distance, on the flat sheet,
// between it and the point that the exact solution puts at its place; without the rim and the last tenth of a wall.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/axisymmetric.hpp"
#include "tests/unit/shapes.hpp"
#include "worker/forming/formed_sheet.hpp"

namespace {

using namespace vacuform;

constexpr double degree = std::numbers::pi / 180;

struct Errors {
  double mean = 0, p99 = 0, most = 0, seconds = 0;
  int iterations = 0, steps = 0;
};

// `exact`: from a place on the mold to the rest radius (or distance from the middle) that lands there, or nothing; `rest`: of
// a point of the flat sheet.
template <class Exact, class Rest>
Errors errors_of(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                 std::optional<double> step_mm, const Exact& exact, const Rest& rest) {
  FormingSettings forming;
  forming.step_mm = step_mm;
  const auto start = std::chrono::steady_clock::now();
  const auto formed = form(mold, sheet, machine, forming, TemperatureField(140), Context{});
  Errors out;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!formed) {
    std::fprintf(stderr, "%s\n", formed.error().text().c_str());
    return out;
  }
  std::vector<double> errors;
  for (std::size_t i = 0; i < formed->rest.size(); ++i) {
    if (formed->contact[i] != Contact::mold) continue;
    const std::optional<double> wanted = exact(formed->formed[i]);
    if (!wanted) continue;
    errors.push_back(std::abs(rest(formed->rest[i]) - *wanted));
    out.mean += errors.back();
  }
  if (errors.empty()) return out;
  std::sort(errors.begin(), errors.end());
  out.mean /= static_cast<double>(errors.size());
  out.p99 = errors[errors.size() * 99 / 100], out.most = errors.back();
  out.iterations = formed->summary.iterations;
  out.steps = formed->summary.drape_steps + formed->summary.vacuum_steps;
  return out;
}

struct Case {
  std::string name;
  std::function<Errors(double grid_mm, std::optional<double> step_mm)> run;
};

Case hemisphere_under(double ring) {
  constexpr double R = 75;
  return {"hemisphere " + std::to_string(ring).substr(0, 3),
          [ring](double grid_mm, std::optional<double> step_mm) {
            SheetSettings sheet;
            sheet.resolution_mm = grid_mm;
            sheet.width_mm = sheet.height_mm = 2 * ring * R + 10;
            MachineSettings machine;
            machine.window = WindowShape::circle;
            machine.window_width_mm = 2 * ring * R;
            const auto landed = exact::male_hemisphere(MembraneLaw::neo_hookean, ring, 81 * degree);
            return errors_of(
                hemisphere(R, 180, 360), sheet, machine, step_mm,
                [&](const Eigen::Vector3d& p) -> std::optional<double> {
                  const double polar = std::atan2(p.head<2>().norm(), p.z());
                  if (polar < 5 * degree || polar > 80 * degree) return std::nullopt;
                  return R * exact::at(landed, polar).rest;
                },
                [](const Eigen::Vector2d& rest) { return rest.norm(); });
          }};
}

Mold cone(double R, int sectors) {
  Mold mold;
  mold.mesh.vertices.push_back({0, 0, R});
  for (int j = 0; j < sectors; ++j) {
    const double around = 2 * std::numbers::pi * j / sectors;
    mold.mesh.vertices.push_back({R * std::cos(around), R * std::sin(around), 0});
    mold.mesh.triangles.push_back({0, 1 + j, 1 + (j + 1) % sectors});
  }
  mold.top = {0, 0, R};
  return mold;
}

// Rest radius of what lands at a radius, over the base radius (axisymmetric Newton solver).
Case cone_under_a_ring() {
  constexpr double R = 75;
  return {"cone 45", [](double grid_mm, std::optional<double> step_mm) {
            SheetSettings sheet;
            sheet.resolution_mm = grid_mm;
            sheet.width_mm = sheet.height_mm = 3 * R + 10;
            MachineSettings machine;
            machine.window = WindowShape::circle;
            machine.window_width_mm = 3 * R;
            static constexpr std::pair<double, double> table[] = {{.1, .10281}, {.2, .20517}, {.3, .30714},
                                                                  {.5, .52211}, {.7, .74642}, {.9, .97145}};
            return errors_of(
                cone(R, 720), sheet, machine, step_mm,
                [&](const Eigen::Vector3d& p) -> std::optional<double> {
                  for (const auto& [r, rest] : table)  // near a value of the table its ratio holds
                    if (std::abs(p.head<2>().norm() / R - r) < 0.004) return rest / r * p.head<2>().norm();
                  return std::nullopt;
                },
                [](const Eigen::Vector2d& rest) { return rest.norm(); });
          }};
}

// A block with a groove along y, 12 times as long as wide.
Mold groove(double half_width, double angle) {
  const double land = 4, length = 12 * half_width, depth = half_width * std::tan(angle), top = depth + 5;
  Mold mold;
  auto& m = mold.mesh;
  const auto vertex = [&](double x, double y, double z) {
    m.vertices.push_back({x, y, z});
    return static_cast<int>(m.vertices.size()) - 1;
  };
  const auto quad = [&](int a, int b, int c, int d) {
    m.triangles.push_back({a, b, c});
    m.triangles.push_back({a, c, d});
  };
  const double X = half_width + land, Y = length + land;
  const int rim[4] = {vertex(-half_width, -length, top), vertex(half_width, -length, top),
                      vertex(half_width, length, top), vertex(-half_width, length, top)};
  const int edge[4] = {vertex(-X, -Y, top), vertex(X, -Y, top), vertex(X, Y, top), vertex(-X, Y, top)};
  const int foot[4] = {vertex(-X, -Y, 0), vertex(X, -Y, 0), vertex(X, Y, 0), vertex(-X, Y, 0)};
  const int bottom[2] = {vertex(0, -length, top - depth), vertex(0, length, top - depth)};
  for (int k = 0; k < 4; ++k) {
    quad(edge[k], edge[(k + 1) % 4], rim[(k + 1) % 4], rim[k]);
    quad(foot[k], foot[(k + 1) % 4], edge[(k + 1) % 4], edge[k]);
  }
  quad(rim[0], bottom[0], bottom[1], rim[3]);
  quad(rim[2], bottom[1], bottom[0], rim[1]);
  m.triangles.push_back({rim[1], bottom[0], rim[0]});
  m.triangles.push_back({rim[3], bottom[1], rim[2]});
  quad(foot[3], foot[2], foot[1], foot[0]);
  mold.top = {X, Y, top};
  return mold;
}

// Plane strain: what lands at the slant distance S of the length T comes from T cos a (1 - (1 - S/T)^(tan a / a)) off the rim.
Case groove_of(double degrees) {
  return {"groove " + std::to_string(degrees).substr(0, 4),
          [degrees](double grid_mm, std::optional<double> step_mm) {
            constexpr double half = 16, gap = 8, land = 4;
            const double angle = degrees * degree, depth = half * std::tan(angle),
                         length = half / std::cos(angle);
            SheetSettings sheet;
            sheet.resolution_mm = grid_mm;
            sheet.thickness_mm = 0.2;  // the vacuum presses it far into the corner
            sheet.width_mm = 2 * (half + land + gap), sheet.height_mm = 2 * (12 * half + land + gap);
            MachineSettings machine;
            machine.window_width_mm = sheet.width_mm, machine.window_height_mm = sheet.height_mm;
            machine.drape_height_mm = depth + 5 - 0.01;
            return errors_of(
                groove(half, angle), sheet, machine, step_mm,
                [&](const Eigen::Vector3d& p) -> std::optional<double> {
                  const double share = (half - std::abs(p.x())) / half;
                  if (std::abs(p.y()) > half || share < 0.02 || share > 0.9) return std::nullopt;
                  return half - length * std::cos(angle) * (1 - std::pow(1 - share, std::tan(angle) / angle));
                },
                [](const Eigen::Vector2d& rest) { return std::abs(rest.x()); });
          }};
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::optional<double>> steps;
  std::vector<double> grids;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--step" && i + 1 < argc)
      steps.emplace_back(std::atof(argv[++i]));
    else
      grids.push_back(std::atof(argv[i]));
  if (steps.empty()) steps = {std::nullopt};
  if (grids.empty()) grids = {6, 3, 1.5};
  std::printf("%-15s %7s %7s %8s %8s %8s %6s %6s %6s %8s\n", "case", "grid mm", "step mm", "mean mm",
              "p99 mm", "max mm", "order", "steps", "its", "seconds");
  for (const Case& c : {hemisphere_under(1.3), hemisphere_under(1.5), hemisphere_under(2),
                        cone_under_a_ring(), groove_of(30), groove_of(52.5)})
    for (const auto& step : steps) {
      Errors before;
      for (const double grid : grids) {
        const Errors e = c.run(grid, step);
        std::printf(
            "%-15s %7.2f %7s %8.4f %8.4f %8.4f %6s %6d %6d %8.2f\n", c.name.c_str(), grid,
            step ? std::to_string(*step).substr(0, 4).c_str() : "auto", e.mean, e.p99, e.most,
            before.mean > 0 ? std::to_string(std::log2(before.mean / e.mean)).substr(0, 5).c_str() : "",
            e.steps, e.iterations, e.seconds);
        std::fflush(stdout);
        before = e;
      }
    }
}
