#include "worker/scan/closing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/scan/cutting.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/welding.hpp"

namespace vacuform {
namespace {

constexpr double large_share = 0.25;
constexpr double platform_cosine = 0.5;
constexpr double below_mm = 1.0;
constexpr int rounds = 4;

// Removes every triangle at an edge that is not shared properly. Returns how many.
std::size_t drop_broken(TriangleMesh& mesh) {
  const auto uses = edge_uses(mesh);
  std::vector<char> drop(mesh.triangles.size(), 0);
  for (std::size_t i = 0, next; i < uses.size(); i = next) {
    for (next = i + 1;
         next < uses.size() && uses[next].low == uses[i].low && uses[next].high == uses[i].high;)
      ++next;
    if (next - i > 2 || (next - i == 2 && uses[i].forward == uses[i + 1].forward))
      for (std::size_t k = i; k < next; ++k) drop[uses[k].triangle] = 1;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < drop.size(); ++i)
    if (!drop[i]) mesh.triangles[kept++] = mesh.triangles[i];
  const std::size_t dropped = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  if (dropped > 0) drop_unused_vertices(mesh);
  return dropped;
}

struct Opening {
  std::vector<int> loop;
  double across = 0;       // diagonal of its box
  Eigen::Vector3d normal;  // of the missing face, outwards, by area
};

std::vector<Opening> openings(const TriangleMesh& mesh) {
  std::vector<Opening> found;
  for (auto& loop : border_loops(mesh)) {
    Opening opening;
    Eigen::Vector3d low = mesh.vertices[loop.front()], high = low, sum = Eigen::Vector3d::Zero();
    const Eigen::Vector3d first = low;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto& p = mesh.vertices[loop[i]];
      const auto& q = mesh.vertices[loop[(i + 1) % loop.size()]];
      low = low.cwiseMin(p), high = high.cwiseMax(p);
      sum += (p - first).cross(q - first) / 2;
    }
    opening.loop = std::move(loop);
    opening.across = (high - low).norm();
    opening.normal = sum;
    found.push_back(std::move(opening));
  }
  return found;
}

// Walls from the loop straight down to z = bottom, and the flat cap there.
bool wall_in(TriangleMesh& mesh, const std::vector<int>& loop, double bottom) {
  const int first = static_cast<int>(mesh.vertices.size());
  const int n = static_cast<int>(loop.size());
  std::vector<int> foot;
  for (int i = 0; i < n; ++i) {
    Eigen::Vector3d p = mesh.vertices[loop[static_cast<std::size_t>(i)]];
    p.z() = bottom;
    mesh.vertices.push_back(p);
    foot.push_back(first + i);
  }
  const auto cap = flat_cap(mesh.vertices, {foot});
  if (!cap) {
    mesh.vertices.resize(static_cast<std::size_t>(first));
    return false;
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    const int a = loop[i], b = loop[j];
    mesh.triangles.push_back({a, b, first + j});
    mesh.triangles.push_back({a, first + j, first + i});
  }
  mesh.triangles.insert(mesh.triangles.end(), cap->begin(), cap->end());
  return true;
}

void fill_with_fan(TriangleMesh& mesh, const std::vector<int>& loop) {
  if (loop.size() == 3) {
    mesh.triangles.push_back({loop[0], loop[1], loop[2]});
    return;
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const int v : loop) middle += mesh.vertices[v];
  const int hub = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(middle / static_cast<double>(loop.size()));
  for (std::size_t i = 0; i < loop.size(); ++i)
    mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], hub});
}

// Whether at least two pieces have wide openings: they are then patches of one surface, with gaps between them.
bool in_patches(const TriangleMesh& mesh) {
  std::vector<int> piece_of;
  const int count = connected_pieces(mesh, piece_of);
  if (count < 2) return false;
  std::vector<Box> boxes(static_cast<std::size_t>(count),
                         {Eigen::Vector3d::Constant(HUGE_VAL), Eigen::Vector3d::Constant(-HUGE_VAL)});
  std::vector<int> piece_of_vertex(mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const int v : mesh.triangles[i]) {
      auto& box = boxes[piece_of[i]];
      const auto& p = mesh.vertices[v];
      box.low = box.low.cwiseMin(p), box.high = box.high.cwiseMax(p);
      piece_of_vertex[v] = piece_of[i];
    }
  std::vector<char> open(static_cast<std::size_t>(count), 0);
  for (const auto& opening : openings(mesh)) {
    const auto piece = static_cast<std::size_t>(piece_of_vertex[opening.loop.front()]);
    if (opening.across > large_share * boxes[piece].size().norm()) open[piece] = 1;
  }
  return std::count(open.begin(), open.end(), 1) >= 2;
}

}  // namespace

Closing close_skin(const TriangleMesh& skin) {
  Closing closing;
  closing.mesh = skin;
  if (in_patches(skin)) return closing;
  const std::size_t given = skin.triangles.size();
  const Box box = bounds(skin);
  std::size_t dropped = drop_broken(closing.mesh);
  for (int round = 0; round < rounds && !closing.mesh.triangles.empty(); ++round) {
    if (dropped * 10 > given) return closing;  // a soup: better wrapped than repaired
    for (const auto& opening : openings(closing.mesh)) {
      if (opening.loop.size() < 3) continue;
      const bool large = opening.across > large_share * box.size().norm();
      const bool over_platform = -opening.normal.z() > platform_cosine * opening.normal.norm();
      if (large && over_platform && wall_in(closing.mesh, opening.loop, box.low.z() - below_mm)) {
        ++closing.holes_capped;
        continue;
      }
      // From the second round on, fills with new vertices: a filling that uses only those of the loop can repeat an
      // existing edge.
      const auto filling =
          round == 0 ? fill_hole(closing.mesh.vertices, opening.loop) : std::vector<Triangle>{};
      if (filling.empty())
        fill_with_fan(closing.mesh, opening.loop);
      else
        closing.mesh.triangles.insert(closing.mesh.triangles.end(), filling.begin(), filling.end());
      ++closing.holes_closed;
      closing.largest_filled_mm = std::max(closing.largest_filled_mm, opening.across);
    }
    if (is_watertight(closing.mesh)) {
      closing.sound = signed_volume(closing.mesh) > 0;
      return closing;
    }
    dropped += drop_broken(closing.mesh);
  }
  return closing;
}

}  // namespace vacuform
