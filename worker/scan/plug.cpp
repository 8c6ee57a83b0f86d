#include "worker/scan/plug.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"

namespace vacuform {
namespace {

constexpr double on_platform_mm =
    5e-4;  // half of what cutting leaves between the platform and the next vertex
constexpr double least_base_mm2 = 1;

const Eigen::Vector3d& at(const TriangleMesh& mesh, int v) { return mesh.vertices[v]; }

// The triangles that lie on the platform.
std::vector<int> base_of(const TriangleMesh& mesh) {
  std::vector<int> base;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if (std::max({at(mesh, t[0]).z(), at(mesh, t[1]).z(), at(mesh, t[2]).z()}) < on_platform_mm)
      base.push_back(static_cast<int>(i));
  }
  return base;
}

// A corner of the base: triangle base[n / 3], its vertex n % 3.
struct Corners {
  const TriangleMesh& mesh;
  const std::vector<int>& base;
  int vertex(int corner) const {
    const int t = base[corner / 3];
    return mesh.triangles[t][corner % 3];
  }
  static int next(int corner) { return corner / 3 * 3 + (corner + 1) % 3; }
};

// Lowers the base to z = 0 and connects it by walls to where it was. Corners that are connected over the base's inner
// edges share their new vertex; outlines that merely touch in one vertex get one each, otherwise four walls would share
// an edge.
void extrude(TriangleMesh& mesh, const std::vector<int>& base) {
  const Corners corners{mesh, base};
  struct Side {
    int low, high, corner;  // the edge from this corner to the next
  };
  std::vector<Side> sides;
  for (int c = 0; c < 3 * static_cast<int>(base.size()); ++c) {
    const int a = corners.vertex(c), b = corners.vertex(Corners::next(c));
    sides.push_back({std::min(a, b), std::max(a, b), c});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.corner} < std::array{b.low, b.high, b.corner};
  });

  std::vector<int> parent(sides.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int c) {
    for (int* up = &parent[c]; *up != c; up = &parent[c]) c = *up = parent[*up];
    return c;
  };
  const auto join = [&](int a, int b) {
    const int low = std::min(root(a), root(b)), high = std::max(root(a), root(b));
    parent[high] = low;
  };
  std::vector<int> rim;
  for (std::size_t i = 0; i < sides.size();) {
    const bool inner =
        i + 1 < sides.size() && sides[i].low == sides[i + 1].low && sides[i].high == sides[i + 1].high;
    if (inner) {  // the two triangles run along it in opposite directions
      join(sides[i].corner, Corners::next(sides[i + 1].corner));
      join(Corners::next(sides[i].corner), sides[i + 1].corner);
    } else {
      rim.push_back(sides[i].corner);
    }
    i += inner ? 2 : 1;
  }

  std::vector<int> lowered(sides.size(), -1);
  const auto lower = [&](int corner) {
    int& v = lowered[root(corner)];
    if (v < 0) {
      v = static_cast<int>(mesh.vertices.size());
      const Eigen::Vector3d p = at(mesh, corners.vertex(corner));
      mesh.vertices.emplace_back(p.x(), p.y(), 0);
    }
    return v;
  };
  std::vector<Triangle> walls;
  std::sort(rim.begin(), rim.end());
  for (const int corner : rim) {
    // The base runs along its rim from a to b, the faces around it from b to a.
    const int a = corners.vertex(corner), b = corners.vertex(Corners::next(corner));
    const int below_a = lower(corner), below_b = lower(Corners::next(corner));
    walls.push_back({a, b, below_b});
    walls.push_back({a, below_b, below_a});
  }
  for (std::size_t i = 0; i < base.size(); ++i) {
    const int c = 3 * static_cast<int>(i);
    const Triangle moved{lower(c), lower(c + 1), lower(c + 2)};
    walls.push_back(moved);
  }
  std::vector<Triangle> all;
  std::size_t next = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (next < base.size() && base[next] == static_cast<int>(i))
      ++next;
    else
      all.push_back(mesh.triangles[i]);
  all.insert(all.end(), walls.begin(), walls.end());
  mesh.triangles = std::move(all);
  drop_unused_vertices(mesh);
}

}  // namespace

Result<Mold> on_plug(Mold mold, double height_mm) {
  if (height_mm == 0) return mold;
  const auto base = base_of(mold.mesh);
  double area = 0;
  for (const int i : base) area += area_vector(mold.mesh, mold.mesh.triangles[i]).norm();
  if (area < least_base_mm2)
    return fail(Code::unusable_scan, "the mold has no flat base that a plug could carry",
                "machine.plug_height_mm", "trim the scan (scan.trim_mm), so that it stands flat");
  const auto raise = [&](double z) { return static_cast<double>(static_cast<float>(z + height_mm)); };
  for (auto& p : mold.mesh.vertices) p.z() = raise(p.z());
  extrude(mold.mesh, base);
  mold.top.z() = raise(mold.top.z());
  mold.placing.origin.z() += height_mm;
  for (Undercut& undercut : mold.undercuts) undercut.place.z() += height_mm;
  for (Warning& warning : mold.warnings) {
    for (Warning::Mark& mark : warning.marks) mark.place_mm[2] += height_mm;
    if (warning.code == "undercut") warning = undercut_warning(mold.undercuts);  // its text says the height
  }
  return mold;
}

}  // namespace vacuform
