// Forming against exact solutions: where the sheet lands, on finer grids and with smaller steps, and the observed order.
//
//   bench_exact [--step MM ...] [--case WORD] [GRID_MM ...]    (default: its own step, every case, grids of 6 3 1.5 mm)
//
// Hemispheres of R = 75 mm under clamp rings of 1.3, 1.5 and 2 R, and a cone of 45 degrees and base radius 75 mm under a
// ring of 1.5, lowered to the platform, then vacuum; a long box of 20 mm height beside a frame at 20 mm from it; grooves
// of 32 mm width whose walls make 30 and 52.5 degrees with the flat sheet, under vacuum alone. The error of a vertex on
// the mold is the distance, on the flat sheet, between it and the point that the exact solution puts at its place; without
// the rim and the last tenth of a wall. A circle of radius 50 mm inflated to a pole stretch of 1.5 without touching
// anything: there the error is the distance of a vertex from its exact place. Neo-Hookean; in plane strain (box and
// grooves) any law lands the same, so these are formed of a viscous sheet too. The viscous hemisphere has no exact
// solution: it is held to the same grid with a step of an eighth.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/fixtures/shapes.hpp"
#include "tests/unit/worker/forming/axisymmetric.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/material.hpp"

namespace {

using namespace vacuform;

constexpr double degree = std::numbers::pi / 180, forming_c = 140;

struct Errors {
  double mean = 0, p99 = 0, most = 0, seconds = 0;
  int iterations = 0, steps = 0;
};

using Rest = Eigen::Vector2d;
using Place = Eigen::Vector3d;

// `error`: of a vertex by its place on the flat sheet and in space, or nothing where it does not count.
template <class Error>
Errors errors_of(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                 const FormingSettings& forming, Contact with, const Error& error) {
  const auto start = std::chrono::steady_clock::now();
  const auto formed = form(mold, sheet, machine, forming, TemperatureField(forming_c), Context{});
  Errors out;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!formed) {
    std::fprintf(stderr, "%s\n", formed.error().text().c_str());
    return out;
  }
  std::vector<double> errors;
  for (std::size_t i = 0; i < formed->rest.size(); ++i) {
    if (formed->contact[i] != with) continue;
    if (const std::optional<double> e = error(formed->rest[i], formed->formed[i])) errors.push_back(*e);
  }
  if (errors.empty()) return out;
  std::sort(errors.begin(), errors.end());
  for (const double e : errors) out.mean += e / static_cast<double>(errors.size());
  out.p99 = errors[errors.size() * 99 / 100], out.most = errors.back();
  out.iterations = formed->summary.iterations;
  out.steps = formed->summary.drape_steps + formed->summary.vacuum_steps;
  return out;
}

// A sheet 10 mm wider than the round window that it is clamped in.
std::pair<SheetSettings, MachineSettings> clamped_circle(double window_mm, double grid_mm) {
  SheetSettings sheet;
  sheet.resolution_mm = grid_mm;
  sheet.width_mm = sheet.height_mm = window_mm + 10;
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = window_mm;
  return {sheet, machine};
}

struct Case {
  std::string name;
  std::function<Errors(double grid_mm, const FormingSettings& forming)> run;
};

Case hemisphere_under(double ring) {
  constexpr double R = 75;
  return {"hemisphere " + std::to_string(ring).substr(0, 3),
          [ring](double grid_mm, const FormingSettings& forming) {
            auto [sheet, machine] = clamped_circle(2 * ring * R, grid_mm);
            const auto landed = exact::male_hemisphere(MembraneLaw::neo_hookean, ring, 81 * degree);
            return errors_of(hemisphere(R, 180, 360), sheet, machine, forming, Contact::mold,
                             [&](const Rest& rest, const Place& p) -> std::optional<double> {
                               const double polar = std::atan2(p.head<2>().norm(), p.z());
                               if (polar < 5 * degree || polar > 80 * degree) return std::nullopt;
                               return std::abs(rest.norm() - R * exact::at(landed, polar).rest);
                             });
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

// What lands at a radius: its rest radius, both over the base radius, and its thickness over the flat sheet's
// (axisymmetric Newton solver).
Case cone_under_a_ring() {
  constexpr double R = 75;
  return {"cone 45", [](double grid_mm, const FormingSettings& forming) {
            auto [sheet, machine] = clamped_circle(3 * R, grid_mm);
            struct Ring {
              double radius, rest, thickness;
            };
            static constexpr Ring rings[] = {{.1, .10281, .7459}, {.2, .20517, .7408}, {.3, .30714, .7440},
                                             {.5, .52211, .8176}, {.7, .74642, .8519}, {.9, .97145, .8460}};
            return errors_of(cone(R, 720), sheet, machine, forming, Contact::mold,
                             [&](const Rest& flat, const Place& p) -> std::optional<double> {
                               const double radius = p.head<2>().norm() / R;
                               for (const Ring& ring : rings) {
                                 if (std::abs(radius - ring.radius) > 0.004) continue;
                                 // The plastic is kept: rest d(rest) = thickness radius d(slant).
                                 const double slope =
                                     ring.thickness * std::numbers::sqrt2 * ring.radius / ring.rest;
                                 const double rest = ring.rest + slope * (radius - ring.radius);
                                 return std::abs(flat.norm() - R * rest);
                               }
                               return std::nullopt;
                             });
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
          [degrees](double grid_mm, const FormingSettings& forming) {
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
            return errors_of(groove(half, angle), sheet, machine, forming, Contact::mold,
                             [&](const Rest& rest, const Place& p) -> std::optional<double> {
                               const double share = (half - std::abs(p.x())) / half;
                               if (std::abs(p.y()) > half || share < 0.02 || share > 0.9) return std::nullopt;
                               const double wall = length * std::cos(angle) *
                                                   (1 - std::pow(1 - share, std::tan(angle) / angle));
                               return std::abs(std::abs(rest.x()) - (half - wall));
                             });
          }};
}

// A box along y, 12 times as long as the step beside it is wide.
Mold box(double half_width, double half_length, double height) {
  Mold mold;
  auto& m = mold.mesh;
  for (const double z : {0.0, height})
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      m.vertices.push_back({x * half_width, y * half_length, z});
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    m.triangles.push_back({k, next, 4 + next});
    m.triangles.push_back({k, 4 + next, 4 + k});
  }
  m.triangles.insert(m.triangles.end(), {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}});
  mold.top = {half_width, half_length, height};
  return mold;
}

// Plane strain: the film goes straight from the box's edge to the frame, H away and H lower, bulges to a quarter of a
// circle and is pressed into the corner, a circle of radius r there; its tension is the same all along, so what is left
// of its width H on the flat sheet is H (r / H)^(4 / pi), and wall and platform take equal parts.
Case male_box() {
  return {"male box", [](double grid_mm, const FormingSettings& forming) {
            constexpr double H = 20, half = 16, length = 12 * H;
            SheetSettings sheet;
            sheet.resolution_mm = grid_mm;
            sheet.thickness_mm = 0.2;
            sheet.width_mm = 2 * (half + H) + 10, sheet.height_mm = 2 * (length + H) + 10;
            MachineSettings machine;
            machine.window_width_mm = 2 * (half + H), machine.window_height_mm = 2 * (length + H);
            return errors_of(box(half, length, H), sheet, machine, forming, Contact::mold,
                             [&](const Rest& rest, const Place& p) -> std::optional<double> {
                               const double left = p.z() / H;
                               if (std::abs(p.y()) > H || left < 0.1 || left > 0.98) return std::nullopt;
                               const double wall = H / 2 * (1 - std::pow(left, 4 / std::numbers::pi));
                               return std::abs(std::abs(rest.x()) - (half + wall));
                             });
          }};
}

// A tube whose top lies outside of the frame.
Mold tube(double inner, double outer, double height, int sectors) {
  Mold mold;
  auto& m = mold.mesh;
  const std::pair<double, double> profile[] = {{inner, 0}, {outer, 0}, {outer, height}, {inner, height}};
  for (int j = 0; j < sectors; ++j)
    for (const auto& [r, z] : profile) {
      const double around = 2 * std::numbers::pi * j / sectors;
      m.vertices.push_back({r * std::cos(around), r * std::sin(around), z});
    }
  for (int j = 0; j < sectors; ++j)
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * j + k, b = 4 * j + (k + 1) % 4, next = (j + 1) % sectors - j;
      m.triangles.push_back({a, a + 4 * next, b + 4 * next});
      m.triangles.push_back({a, b + 4 * next, b});
    }
  mold.top = {outer, 0, height};
  return mold;
}

// A clamped circle of radius 50 mm under the pressure that stretches its pole 1.5 times; it hangs 40 mm down, in the air.
Case inflated_circle() {
  return {"inflated circle", [](double grid_mm, const FormingSettings& forming) {
            constexpr double R = 50, height = 60, stretch = 1.5;
            const exact::Law law{MembraneLaw::neo_hookean};
            constexpr int rings = 200;
            std::vector<exact::Film> film(rings + 1);  // equally far apart on the flat sheet
            const auto march_to_rim = [&](double p) {  // p: pressure / (modulus x thickness)
              const double a0 = R / rings;
              const Density d = law(stretch, stretch * (1 - 1e-12));
              film[0] = {0, 0, 0, stretch};
              film[1] = {stretch * a0, 0, p / (2 * d.W1 / stretch) * stretch * a0, stretch};
              film[1].z = film[1].r * film[1].slope / 2;
              for (int k = 1; k < rings; ++k)
                film[k + 1] = exact::march(law, p, film[k], k * a0, (k + 1) * a0, 4);
              return film[rings].r;
            };
            double low = 0.5 / R, high = 1.85 / R;  // 1.6436 / R; the more pressure, the narrower
            for (int i = 0; i < 60; ++i) {
              const double middle = (low + high) / 2;
              (march_to_rim(middle) > R ? low : high) = middle;
            }
            auto [sheet, machine] = clamped_circle(2 * R, grid_mm);
            machine.drape_height_mm = height;
            machine.vacuum_kpa = low * shear_modulus_kpa(sheet.material, forming_c) * sheet.thickness_mm;
            return errors_of(tube(R + 2, R + 5, height, 360), sheet, machine, forming, Contact::free,
                             [&](const Rest& rest, const Place& p) -> std::optional<double> {
                               const double at = rest.norm() / R * rings;
                               const int k = std::min(static_cast<int>(at), rings - 1);
                               const double w = at - k;
                               const double r = (1 - w) * film[k].r + w * film[k + 1].r,
                                            z = (1 - w) * film[k].z + w * film[k + 1].z;
                               return std::hypot(p.head<2>().norm() - r,
                                                 p.z() - (height - film[rings].z + z));
                             });
          }};
}

Case viscous(Case c) {
  return {c.name + " viscous", [run = c.run](double grid_mm, const FormingSettings& forming) {
            FormingSettings flowing = forming;
            flowing.model = FormingModel::viscoplastic;
            return run(grid_mm, flowing);
          }};
}

double step_of(const FormingSettings& forming, double grid_mm) {
  return forming.step_mm.value_or(grid_mm / 1.5);
}

// The viscous hemisphere against itself with a step of an eighth: how far apart a vertex lands.
Case viscous_hemisphere() {
  return {"viscous in steps", [](double grid_mm, const FormingSettings& forming) {
            constexpr double R = 75, ring = 1.5;
            auto [sheet, machine] = clamped_circle(2 * ring * R, grid_mm);
            FormingSettings flowing = forming, fine = forming;
            flowing.model = fine.model = FormingModel::viscoplastic;
            flowing.step_mm = step_of(forming, grid_mm);
            fine.step_mm = *flowing.step_mm / 8;
            const Mold mold = hemisphere(R, 180, 360);
            const auto reference = form(mold, sheet, machine, fine, TemperatureField(forming_c), Context{});
            if (!reference) return Errors{};
            std::map<std::pair<double, double>, Place> known;  // by place on the flat sheet
            for (std::size_t i = 0; i < reference->rest.size(); ++i)
              if (reference->contact[i] == Contact::mold)
                known[{reference->rest[i].x(), reference->rest[i].y()}] = reference->formed[i];
            return errors_of(mold, sheet, machine, flowing, Contact::mold,
                             [&](const Rest& rest, const Place& p) -> std::optional<double> {
                               if (std::atan2(p.head<2>().norm(), p.z()) > 80 * degree) return std::nullopt;
                               const auto there = known.find({rest.x(), rest.y()});
                               if (there == known.end()) return std::nullopt;
                               return (there->second - p).norm();
                             });
          }};
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::optional<double>> steps;
  std::vector<double> grids;
  std::string word;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--step" && i + 1 < argc)
      steps.emplace_back(std::atof(argv[++i]));
    else if (std::string_view(argv[i]) == "--case" && i + 1 < argc)
      word = argv[++i];
    else
      grids.push_back(std::atof(argv[i]));
  if (steps.empty()) steps = {std::nullopt};
  if (grids.empty()) grids = {6, 3, 1.5};
  if (std::any_of(grids.begin(), grids.end(), [](double mm) { return mm <= 0; })) {
    std::fputs("usage: bench_exact [--step MM ...] [--case WORD] [GRID_MM ...]\n", stderr);
    return 2;
  }
  std::printf("%-19s %7s %7s %8s %8s %8s %6s %6s %6s %8s\n", "case", "grid mm", "step mm", "mean mm",
              "p99 mm", "max mm", "order", "steps", "its", "seconds");
  for (const Case& c :
       {hemisphere_under(1.3), hemisphere_under(1.5), hemisphere_under(2), cone_under_a_ring(), male_box(),
        groove_of(30), groove_of(52.5), inflated_circle(), viscous(male_box()), viscous(groove_of(30)),
        viscous(groove_of(52.5)), viscous_hemisphere()}) {
    if (c.name.find(word) == std::string::npos) continue;
    for (const auto& step : steps) {
      FormingSettings forming;
      forming.law = MembraneLaw::neo_hookean;
      forming.step_mm = step;
      forming.thin_limit = 0;  // an ideal sheet: around the grooves' block it would tear
      Errors before;
      double grid_before = 0;
      for (const double grid : grids) {
        const Errors e = c.run(grid, forming);
        std::printf("%-19s %7.2f %7s %8.4f %8.4f %8.4f %6s %6d %6d %8.2f\n", c.name.c_str(), grid,
                    step ? std::to_string(*step).substr(0, 4).c_str() : "auto", e.mean, e.p99, e.most,
                    before.mean > 0
                        ? std::to_string(std::log(before.mean / e.mean) / std::log(grid_before / grid))
                              .substr(0, 5)
                              .c_str()
                        : "",
                    e.steps, e.iterations, e.seconds);
        std::fflush(stdout);
        before = e, grid_before = grid;
      }
    }
  }
}
