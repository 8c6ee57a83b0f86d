#include "worker/scan/crumbs.hpp"

#include <algorithm>
#include <cmath>

#include "worker/scan/mold_distance.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr double crumb_share = 1e-3;  // of the volume of the largest piece
constexpr std::size_t most_crumbs_examined = 64;
constexpr int most_rounds = 3;  // a small piece may stand on another small one

// Whether a point lies in or on a closed surface; `height` exceeds the height of the surface.
class Inside {
 public:
  Inside(const TriangleMesh& surface, double height)
      : surface_(surface), rays_(surface), distance_(surface), height_(height) {}
  bool operator()(const Eigen::Vector3d& p) const {
    constexpr double touching_mm = 0.01;
    return lies_below(surface_, rays_, p, height_) || distance_(p) <= touching_mm;
  }

 private:
  const TriangleMesh& surface_;
  RayCaster rays_;
  MoldDistance distance_;
  double height_;
};

}  // namespace

int drop_crumbs(TriangleMesh& cut) {
  std::vector<int> piece_of;
  const auto pieces = static_cast<std::size_t>(connected_pieces(cut, piece_of));
  if (pieces < 2) return 0;
  const Eigen::Vector3d centre = bounds(cut).centre();
  std::vector<double> volume(pieces, 0);
  for (std::size_t i = 0; i < cut.triangles.size(); ++i) {
    const Eigen::Vector3d a = cut.vertices[cut.triangles[i][0]] - centre;
    volume[piece_of[i]] += a.dot(area_vector(cut, cut.triangles[i])) / 3;
  }
  for (double& v : volume) v = std::abs(v);
  const double least = crumb_share * *std::max_element(volume.begin(), volume.end());
  std::vector<char> keep(pieces);
  for (std::size_t i = 0; i < pieces; ++i) keep[i] = volume[i] >= least;

  // The corners of the first small pieces; the others are crumbs.
  std::vector<int> slot(pieces, -1);
  std::vector<std::vector<int>> corners;
  std::vector<std::size_t> number;
  for (std::size_t n = 0; n < pieces && number.size() < most_crumbs_examined; ++n)
    if (!keep[n]) slot[n] = static_cast<int>(number.size()), number.push_back(n);
  corners.resize(number.size());
  for (std::size_t i = 0; i < cut.triangles.size(); ++i)
    if (const int k = slot[piece_of[i]]; k >= 0)
      corners[k].insert(corners[k].end(), cut.triangles[i].begin(), cut.triangles[i].end());
  const double height = bounds(cut).size().z() + 1;
  for (int round = 0; round < most_rounds; ++round) {
    const TriangleMesh others = take_pieces(cut, piece_of, keep);
    const Inside inside(others, height);
    bool more = false;
    for (std::size_t k = 0; k < number.size(); ++k) {
      if (keep[number[k]]) continue;
      keep[number[k]] =
          std::any_of(corners[k].begin(), corners[k].end(), [&](int v) { return inside(cut.vertices[v]); });
      more = more || keep[number[k]];
    }
    if (!more) break;
  }
  cut = take_pieces(cut, piece_of, keep);
  return static_cast<int>(std::count(keep.begin(), keep.end(), 0));
}

}  // namespace vacuform
