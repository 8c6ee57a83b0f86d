// Exact distances along a formed head, by exact_geodesics.hpp and by CGAL's Surface_mesh_shortest_path in the same run.
//
//   bench_geodesics [--json]
//
// neonate-40w and adult-scalp on a 300 mm sheet at default settings: from each of 19 places of rings-19x40mm to 64 points of
// its circle of 20 mm, as an inspection measures a coil. Both get the same triangles, those within 32 mm of the place, and
// one core; what they prepare once for a set of triangles counts, building CGAL's mesh does not. `difference` is the largest
// one between their distances.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/exact_geodesics.hpp"
#include "worker/surface/plane_locator.hpp"

namespace {

using namespace vacuform;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PeerMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using PeerTraits = CGAL::Surface_mesh_shortest_path_traits<Kernel, PeerMesh>;
using Peer = CGAL::Surface_mesh_shortest_path<PeerTraits>;

constexpr double reach_mm = 32, radius_mm = 20;
constexpr int targets = 64;

[[noreturn]] void stop(const std::string& why) {
  std::fprintf(stderr, "bench_geodesics: %s\n", why.c_str());
  std::exit(1);
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

FormedSheet formed_over(const std::string& scan) {
  std::ifstream in(std::string(VACUFORM_SHARED_DATA) + "/scans/" + scan, std::ios::binary);
  if (!in) stop("cannot read the real scan " + scan + "; see tests/fetch-scans");
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  const Settings settings;
  const auto mold = make_mold(bytes, scan, settings.scan, Context{});
  if (!mold) stop(mold.error().text());
  auto sheet =
      form(*mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context{});
  if (!sheet) stop(sheet.error().text());
  return *std::move(sheet);
}

// The middles of 19 circles, 35 mm apart, on the flat sheet: beside the lines of the grid, since CGAL 5.5 finds longer paths
// from a source on an edge.
std::vector<Eigen::Vector2d> hexagon() {
  std::vector<Eigen::Vector2d> out;
  for (int j = -2; j <= 2; ++j)
    for (int i = -2; i <= 2; ++i)
      if (std::abs(i + j) <= 2)
        out.emplace_back(0.4 + 35 * (i + j / 2.0), 0.3 + 35 * std::numbers::sqrt3 / 2 * j);
  return out;
}

// The part of a sheet around a place, with vertices of its own, and a source and targets in it.
struct Task {
  std::vector<Triangle> triangles;
  std::vector<Eigen::Vector3d> places;
  SheetPoint source;
  std::vector<SheetPoint> targets;
};

Task task_at(const FormedSheet& sheet, const PlaneLocator& locator, const Eigen::Vector2d& rest) {
  const auto find = [&](const Eigen::Vector2d& at) {
    const auto found = locator.find(at);
    if (!found) stop("a place is beside the sheet");
    return *found;
  };
  Task task;
  const SheetPoint source = find(rest);
  const Eigen::Vector3d middle = interpolate(sheet.triangles, source, sheet.formed);
  std::map<int, int> vertices, triangles;  // number here of those there
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    const Triangle& t = sheet.triangles[k];
    if (std::ranges::any_of(t, [&](int v) { return (sheet.formed[v] - middle).norm() > reach_mm; })) continue;
    triangles[static_cast<int>(k)] = static_cast<int>(task.triangles.size());
    Triangle own{};
    for (int c = 0; c < 3; ++c) {
      const auto [at, added] = vertices.try_emplace(t[c], static_cast<int>(task.places.size()));
      if (added) task.places.push_back(sheet.formed[t[c]]);
      own[c] = at->second;
    }
    task.triangles.push_back(own);
  }
  task.source = {triangles.at(source.triangle), source.weights};
  for (int k = 0; k < targets; ++k) {
    const double turn = 2 * std::numbers::pi * k / targets;
    const SheetPoint target = find(rest + radius_mm * Eigen::Vector2d(std::cos(turn), std::sin(turn)));
    if (const auto own = triangles.find(target.triangle); own != triangles.end())
      task.targets.push_back({own->second, target.weights});
  }
  return task;
}

std::vector<double> ours(const Task& task, double& seconds) {
  const double start = cpu_seconds();
  const PathMesh mesh(task.triangles, task.places);
  Geodesics paths(mesh);
  paths.begin_at(task.source, reach_mm);
  std::vector<double> out;
  for (const SheetPoint& target : task.targets) {
    const auto path = paths.to(target);
    out.push_back(path ? path->length : NAN);
  }
  seconds += cpu_seconds() - start;
  return out;
}

std::vector<double> peers(const Task& task, double& seconds) {
  PeerMesh mesh;
  std::vector<PeerMesh::Vertex_index> vertices;
  for (const auto& p : task.places) vertices.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
  std::vector<PeerMesh::Face_index> faces;
  for (const Triangle& t : task.triangles)
    faces.push_back(mesh.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]));
  const auto location = [&](const SheetPoint& at) {
    const auto face = faces[at.triangle];
    const auto h = mesh.halfedge(face);
    const PeerMesh::Vertex_index order[] = {mesh.source(h), mesh.target(h), mesh.target(mesh.next(h))};
    PeerTraits::Barycentric_coordinates weights{};
    for (std::size_t i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c)
        if (order[i] == vertices[task.triangles[at.triangle][c]]) weights[i] = at.weights[c];
    return Peer::Face_location{face, weights};
  };
  const double start = cpu_seconds();
  Peer paths(mesh);
  const auto source = location(task.source);
  paths.add_source_point(source.first, source.second);
  std::vector<double> out;
  for (const SheetPoint& target : task.targets) {
    const auto at = location(target);
    const double length = paths.shortest_distance_to_source_points(at.first, at.second).first;
    out.push_back(length >= 0 && length <= reach_mm ? length : NAN);
  }
  seconds += cpu_seconds() - start;
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc > 1 && std::string_view(argv[1]) == "--json";
  auto rows = nlohmann::ordered_json::array();
  if (!json)
    std::printf("%-22s %9s %9s %9s %9s %9s %14s\n", "scan", "triangles", "distances", "ours s", "CGAL s",
                "ratio", "difference mm");
  for (const std::string scan : {"neonate-40w.stl", "adult-scalp-ascii.ply"}) {
    const FormedSheet sheet = formed_over(scan);
    const PlaneLocator locator(sheet.triangles, sheet.rest);
    double our_seconds = 0, peer_seconds = 0, difference = 0;
    std::size_t triangles = 0, distances = 0;
    for (const Eigen::Vector2d& rest : hexagon()) {
      const Task task = task_at(sheet, locator, rest);
      triangles += task.triangles.size(), distances += task.targets.size();
      const auto a = ours(task, our_seconds), b = peers(task, peer_seconds);
      for (std::size_t k = 0; k < a.size(); ++k) {
        if (std::isnan(a[k]) != std::isnan(b[k])) stop("one finds a path that the other does not");
        if (!std::isnan(a[k])) difference = std::max(difference, std::abs(a[k] - b[k]));
      }
    }
    if (json)
      rows.push_back({{"scan", scan},
                      {"triangles", triangles},
                      {"distances", distances},
                      {"seconds", our_seconds},
                      {"cgal_seconds", peer_seconds},
                      {"difference_mm", difference}});
    else
      std::printf("%-22s %9zu %9zu %9.3f %9.3f %9.1f %14.1e\n", scan.c_str(), triangles, distances,
                  our_seconds, peer_seconds, peer_seconds / our_seconds, difference);
  }
  if (json) std::printf("%s\n", rows.dump(2).c_str());
  return 0;
}
