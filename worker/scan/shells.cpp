#include "worker/scan/shells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "api/job_limits.hpp"
#include "worker/scan/bodies.hpp"
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
      low[n] = low[n].cwiseMin(mesh.vertices[v]);
      high[n] = high[n].cwiseMax(mesh.vertices[v]);
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
  for (std::size_t i = 0; i < largest.size(); ++i) rank[pieces[i].number] = static_cast<int>(i);
  std::vector<int> number(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const int k = rank[piece_of[i]];
    if (k < 0) continue;
    TriangleMesh& piece = largest[k];
    Triangle t = mesh.triangles[i];
    for (int& v : t) {
      int& n = number[v];
      if (n < 0) {
        n = static_cast<int>(piece.vertices.size());
        piece.vertices.push_back(mesh.vertices[v]);
      }
      v = n;
    }
    piece.triangles.push_back(t);
  }
  return largest;
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
    neighbours[ta][filled[ta]++] = {b.triangle, agrees};
    neighbours[tb][filled[tb]++] = {a.triangle, agrees};
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
        if (n.triangle < 0 || patch[n.triangle] >= 0) continue;
        patch[n.triangle] = patches;
        flip[n.triangle] = flip[t] ^ !n.agrees;
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
    const auto n = static_cast<std::size_t>(patch[triangle]);
    const auto& u = uses[use];
    const Eigen::Vector3d &a = mesh.vertices[u.low], &b = mesh.vertices[u.high];
    const double length = (b - a).norm();
    reference[n] += length * (a + b) / 2;
    weight[n] += length;
  }
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    const auto n = static_cast<std::size_t>(patch[i]);
    if (weight[n] == 0) reference[n] = mesh.vertices[mesh.triangles[i][0]];
  }
  for (std::size_t n = 0; n < weight.size(); ++n)
    if (weight[n] > 0) reference[n] /= weight[n];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto n = static_cast<std::size_t>(patch[i]);
    const Eigen::Vector3d a = mesh.vertices[mesh.triangles[i][0]] - reference[n];
    volume[n] += (flip[i] ? -1 : 1) * a.dot(area_vector(mesh, mesh.triangles[i])) / 3;
  }
  double turned = 0, total = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const double area = area_vector(mesh, mesh.triangles[i]).norm();
    const bool turn = flip[i] != (volume[patch[i]] < 0);
    if (turn) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    total += area;
    turned += turn ? area : 0;
  }
  return total > 0 ? turned / total : 0;
}

std::string described(const Body& body) {
  const auto triple = [](const Eigen::Vector3d& v, const char* between) {
    return short_decimal(v.x()) + between + short_decimal(v.y()) + between + short_decimal(v.z());
  };
  return triple(body.size, " x ") + " at (" + triple(body.centre, ", ") + ") in the file";
}

BodyChoice choice_of(std::size_t number) {
  return static_cast<BodyChoice>(static_cast<int>(BodyChoice::first) + static_cast<int>(number));
}

// To take one of the bodies, as far as scan.body can name them.
std::vector<Proposal> to_take_one(const std::vector<Body>& bodies, bool only_heads) {
  std::vector<Proposal> proposals;
  for (std::size_t n = 0; n < bodies.size() && choice_of(n) <= BodyChoice::eighth; ++n)
    if (!only_heads || bodies[n].is_head)
      proposals.push_back({{{"scan.body", name(choice_of(n))}}, described(bodies[n])});
  return proposals;
}

// The number of the chosen body; nothing if all are kept.
Result<std::optional<std::size_t>> choose_body(const std::vector<Body>& bodies, BodyChoice choice,
                                               OuterSkin& skin) {
  const auto heads = std::ranges::count_if(bodies, &Body::is_head);
  if (choice == BodyChoice::automatic && heads > 1)
    return fail(Code::unusable_scan,
                "the scan contains " + std::to_string(heads) + " separate bodies that can be heads",
                "scan.body", "choose one of them", to_take_one(bodies, true),
                "set scan.body=all to form all of them as one mold");
  if (choice >= BodyChoice::first) {
    const auto number =
        static_cast<std::size_t>(static_cast<int>(choice) - static_cast<int>(BodyChoice::first));
    if (number < bodies.size()) return std::optional(number);
    if (number == 0) return std::optional<std::size_t>();  // a shell is no body, but it is the only one
    return fail(Code::unusable_scan,
                "the scan has no " + std::string(name(choice)) + " body: it contains " +
                    std::to_string(bodies.size()),
                "scan.body", "choose one of them",
                bodies.size() > 1
                    ? to_take_one(bodies, false)
                    : std::vector<Proposal>{{{{"scan.body", name(BodyChoice::automatic)}}, ""}});
  }
  if (choice == BodyChoice::automatic && bodies.size() > 1)
    skin.warning = Warning{"several-bodies",
                           "The scan contains " + std::to_string(bodies.size()) +
                               " large separate bodies, and all of them are in the mold",
                           {},
                           Warning::Figure{static_cast<double>(bodies.size()), "bodies", 1.0},
                           {},
                           {},
                           to_take_one(bodies, false)};
  return std::optional<std::size_t>();
}

// The body that a piece is nearest to.
std::size_t nearest_body(const TriangleMesh& piece, const std::vector<Body>& bodies) {
  const Eigen::Vector3d centre = bounds(piece).centre();
  const auto distance = [&](const Body& body) {
    return (centre - body.centre).cwiseQuotient(body.size).norm();
  };
  return static_cast<std::size_t>(std::ranges::min_element(bodies, {}, distance) - bodies.begin());
}

}  // namespace

Result<OuterSkin> outer_skin(const TriangleMesh& mesh, BodyChoice choice, const ScanProgress& progress) {
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
  const auto largest =
      skin.components > 1 ? largest_pieces(mesh, piece_of, pieces) : std::vector<TriangleMesh>{};
  const auto bodies = find_bodies(largest);
  VACUFORM_CHECK(progress.tick());
  VACUFORM_TRY(chosen, choose_body(bodies, choice, skin));
  if (!chosen && pieces.front().area < soup_area * area &&
      pieces.front().diagonal < soup_size * robust_size(mesh)) {
    skin.soup = true;
    skin.mesh = mesh;
  } else if (skin.components == 1) {
    skin.mesh = mesh;
  } else {
    std::vector<char> keep(static_cast<std::size_t>(skin.components), 0);
    const std::size_t main_piece = chosen ? static_cast<std::size_t>(bodies[*chosen].piece) : 0;
    keep[pieces[main_piece].number] = 1;
    const RayCaster main(largest[main_piece]);
    for (std::size_t i = 0; i < largest.size(); ++i) {
      VACUFORM_CHECK(progress.tick());
      if (i == main_piece || (chosen && nearest_body(largest[i], bodies) != *chosen)) continue;
      const double share = pieces[i].diagonal / pieces[main_piece].diagonal;
      keep[pieces[i].number] = belongs(largest[i], share, main, 2 * pieces[main_piece].diagonal);
    }
    skin.components_dropped = static_cast<int>(std::count(keep.begin(), keep.end(), 0));
    skin.mesh = take_pieces(mesh, piece_of, keep);
  }
  VACUFORM_CHECK(progress.tick());
  skin.turned_inside_out = orient(skin.mesh) > 0.5;
  return skin;
}

}  // namespace vacuform
