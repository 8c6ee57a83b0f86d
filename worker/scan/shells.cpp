#include "worker/scan/shells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "api/job_limits.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/welding.hpp"

namespace vacuform {
namespace {

constexpr double debris_share = 0.05;     // of the main piece's diagonal
constexpr double small_share = 0.5;       // of the same: larger ones inside except for a tip are inner skins
constexpr double soup_size = 0.5;         // a main piece smaller than this share of everything and with
constexpr double soup_area = 0.2;         // less than this share of the area is a scrap
constexpr int most_pieces_examined = 64;  // the largest ones; real scans keep a handful

struct Piece {
  int number;
  double diagonal;
  double area;
};

std::vector<Piece> measure_pieces(const TriangleMesh& mesh, const std::vector<int>& piece_of, int count) {
  std::vector<Eigen::Vector3d> low(static_cast<std::size_t>(count), Eigen::Vector3d::Constant(HUGE_VAL));
  std::vector<Eigen::Vector3d> high(static_cast<std::size_t>(count), Eigen::Vector3d::Constant(-HUGE_VAL));
  std::vector<double> area(static_cast<std::size_t>(count), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto n = static_cast<std::size_t>(piece_of[i]);
    for (const int v : mesh.triangles[i]) {
      low[n] = low[n].cwiseMin(mesh.vertices[static_cast<std::size_t>(v)]);
      high[n] = high[n].cwiseMax(mesh.vertices[static_cast<std::size_t>(v)]);
    }
    area[n] += area_vector(mesh, mesh.triangles[i]).norm();
  }
  std::vector<Piece> pieces;
  for (int n = 0; n < count; ++n) {
    const auto i = static_cast<std::size_t>(n);
    pieces.push_back({n, (high[i] - low[i]).norm(), area[i]});
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    if (a.diagonal != b.diagonal) return a.diagonal > b.diagonal;
    if (a.area != b.area) return a.area > b.area;
    return a.number < b.number;
  });
  return pieces;
}

// The largest pieces, each as a mesh of its own.
std::vector<TriangleMesh> largest_pieces(const TriangleMesh& mesh, const std::vector<int>& piece_of,
                                         const std::vector<Piece>& pieces) {
  std::vector<int> rank(pieces.size(), -1);
  std::vector<TriangleMesh> largest(std::min<std::size_t>(pieces.size(), most_pieces_examined));
  for (std::size_t i = 0; i < largest.size(); ++i)
    rank[static_cast<std::size_t>(pieces[i].number)] = static_cast<int>(i);
  std::vector<int> number(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const int k = rank[static_cast<std::size_t>(piece_of[i])];
    if (k < 0) continue;
    TriangleMesh& piece = largest[static_cast<std::size_t>(k)];
    Triangle t = mesh.triangles[i];
    for (int& v : t) {
      int& n = number[static_cast<std::size_t>(v)];
      if (n < 0) {
        n = static_cast<int>(piece.vertices.size());
        piece.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
      }
      v = n;
    }
    piece.triangles.push_back(t);
  }
  return largest;
}

// Where a piece lies, by up to 64 of its vertices and the rays from each in 14 directions: a vertex is inside where at
// least 12 meet the main piece, outside where at most 7 do.
struct Place {
  int samples = 0, inside = 0, outside = 0;
};
Place place_of(const TriangleMesh& piece, const RayCaster& main, double reach) {
  const std::size_t stride = std::max<std::size_t>(1, piece.vertices.size() / 64);
  Place place;
  for (std::size_t i = 0; i < piece.vertices.size(); i += stride) {
    int hits = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        Eigen::Vector3d d(0.013, -0.017, 0.011);  // off the axes, so as not to run along edges
        d[axis] += sign;
        hits += main.first_hit(piece.vertices[i], d * reach).has_value();
      }
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      hits += main.first_hit(piece.vertices[i], d * reach).has_value();
    }
    ++place.samples;
    place.inside += hits >= 12;
    place.outside += hits <= 7;
  }
  return place;
}

// Whether a piece other than the main one is part of the outside. A small closed body that partly stands in the main
// piece is a fin, a spike or a nose of a model, however small.
bool belongs(const TriangleMesh& piece, double share_of_diagonal, const RayCaster& main, double reach) {
  const bool debris = share_of_diagonal < debris_share;
  if (debris && !is_watertight(piece)) return false;
  const Place place = place_of(piece, main, reach);
  if (share_of_diagonal < small_share && place.inside > 0 && place.outside > 0 && is_watertight(piece))
    return true;
  return !debris && place.inside * 20 < place.samples * 19;
}

// Makes the directions of triangles agree over edges that exactly two share; then turns each such patch
// outwards. Returns the share of the area that was turned.
double orient(TriangleMesh& mesh) {
  const auto uses = edge_uses(mesh);
  struct Neighbour {
    int triangle = -1;
    bool agrees = true;
  };
  std::vector<std::array<Neighbour, 3>> neighbours(mesh.triangles.size());
  std::vector<int> filled(mesh.triangles.size(), 0);
  std::vector<std::pair<int, int>> border;  // (triangle, use)
  for (std::size_t i = 0, next; i < uses.size(); i = next) {
    for (next = i + 1;
         next < uses.size() && uses[next].low == uses[i].low && uses[next].high == uses[i].high;)
      ++next;
    if (next == i + 1) border.emplace_back(uses[i].triangle, static_cast<int>(i));
    if (next != i + 2) continue;
    const auto &a = uses[i], &b = uses[i + 1];
    const bool agrees = a.forward != b.forward;
    const auto ta = static_cast<std::size_t>(a.triangle), tb = static_cast<std::size_t>(b.triangle);
    neighbours[ta][static_cast<std::size_t>(filled[ta]++)] = {b.triangle, agrees};
    neighbours[tb][static_cast<std::size_t>(filled[tb]++)] = {a.triangle, agrees};
  }

  std::vector<int> patch(mesh.triangles.size(), -1);
  std::vector<char> flip(mesh.triangles.size(), 0);
  std::vector<int> open;
  int patches = 0;
  for (std::size_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (patch[seed] >= 0) continue;
    open.assign(1, static_cast<int>(seed));
    patch[seed] = patches;
    while (!open.empty()) {
      const auto t = static_cast<std::size_t>(open.back());
      open.pop_back();
      for (const auto& n : neighbours[t]) {
        if (n.triangle < 0 || patch[static_cast<std::size_t>(n.triangle)] >= 0) continue;
        patch[static_cast<std::size_t>(n.triangle)] = patches;
        flip[static_cast<std::size_t>(n.triangle)] = flip[t] ^ !n.agrees;
        open.push_back(n.triangle);
      }
    }
    ++patches;
  }

  // The reference point of each patch: the middle of its border; of a closed patch any point, here its first
  // vertex.
  std::vector<Eigen::Vector3d> reference(static_cast<std::size_t>(patches), Eigen::Vector3d::Zero());
  std::vector<double> weight(static_cast<std::size_t>(patches), 0), volume = weight;
  for (const auto& [triangle, use] : border) {
    const auto n = static_cast<std::size_t>(patch[static_cast<std::size_t>(triangle)]);
    const auto& u = uses[static_cast<std::size_t>(use)];
    const Eigen::Vector3d &a = mesh.vertices[static_cast<std::size_t>(u.low)],
                          &b = mesh.vertices[static_cast<std::size_t>(u.high)];
    const double length = (b - a).norm();
    reference[n] += length * (a + b) / 2;
    weight[n] += length;
  }
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    const auto n = static_cast<std::size_t>(patch[i]);
    if (weight[n] == 0) reference[n] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][0])];
  }
  for (std::size_t n = 0; n < weight.size(); ++n)
    if (weight[n] > 0) reference[n] /= weight[n];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto n = static_cast<std::size_t>(patch[i]);
    const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][0])] - reference[n];
    volume[n] += (flip[i] ? -1 : 1) * a.dot(area_vector(mesh, mesh.triangles[i])) / 3;
  }
  double turned = 0, total = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const double area = area_vector(mesh, mesh.triangles[i]).norm();
    const bool turn = flip[i] != (volume[static_cast<std::size_t>(patch[i])] < 0);
    if (turn) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    total += area;
    turned += turn ? area : 0;
  }
  return total > 0 ? turned / total : 0;
}

}  // namespace

Result<OuterSkin> outer_skin(const TriangleMesh& mesh, const ScanProgress& progress) {
  OuterSkin skin;
  std::vector<int> piece_of;
  skin.components = connected_pieces(mesh, piece_of);
  if (skin.components > job_limits.scan_components)
    return fail(Code::too_large,
                "the scan has " + std::to_string(skin.components) + " separate pieces, above the limit of " +
                    std::to_string(job_limits.scan_components),
                {}, "join them, or delete the debris, before uploading it");
  const auto pieces = measure_pieces(mesh, piece_of, skin.components);
  VACUFORM_CHECK(progress.tick());

  if (pieces.empty()) return skin;
  double area = 0;
  for (const auto& piece : pieces) area += piece.area;
  if (pieces.front().area < soup_area * area && pieces.front().diagonal < soup_size * robust_size(mesh)) {
    skin.soup = true;
    skin.mesh = mesh;
  } else if (skin.components == 1) {
    skin.mesh = mesh;
  } else {
    std::vector<char> keep(static_cast<std::size_t>(skin.components), 0);
    keep[static_cast<std::size_t>(pieces.front().number)] = 1;
    const auto largest = largest_pieces(mesh, piece_of, pieces);
    const RayCaster main(largest.front());
    for (std::size_t i = 1; i < largest.size(); ++i) {
      VACUFORM_CHECK(progress.tick());
      const double share = pieces[i].diagonal / pieces.front().diagonal;
      keep[static_cast<std::size_t>(pieces[i].number)] =
          belongs(largest[i], share, main, 2 * pieces.front().diagonal);
    }
    skin.components_dropped = static_cast<int>(std::count(keep.begin(), keep.end(), 0));
    skin.mesh = take_pieces(mesh, piece_of, keep);
  }
  VACUFORM_CHECK(progress.tick());
  skin.turned_inside_out = orient(skin.mesh) > 0.5;
  return skin;
}

}  // namespace vacuform
