#include "worker/scan/poses.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "api/base/decimal.hpp"
#include "worker/scan/smoothing.hpp"
#include "worker/scan/symmetry.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/upright.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double least_flat = 0.02, least_open = 0.02;  // of the area of the skin
constexpr double flat_band = 0.004;                     // of the diagonal
constexpr double flat_cosine = 0.99;

constexpr std::array axes{UpAxis::plus_z,  UpAxis::plus_y, UpAxis::minus_z,
                          UpAxis::minus_y, UpAxis::plus_x, UpAxis::minus_x};

constexpr std::size_t opposite(std::size_t k) { return std::array<std::size_t, 6>{2, 3, 0, 1, 5, 4}[k]; }

constexpr double small_piece = 0.25;  // of the area of the largest piece

// Of the diagonal, for the formable height: undercuts of ears, dents and grain are smaller.
constexpr double pose_ray_share = 1.0 / 125, pose_depth_share = 1.0 / 60, pose_area_share = 1.0 / 900,
                 pose_dome_share = 1.0 / 25;

// The weights of what is known, as logarithms of likelihoods.
constexpr double cut_weight = 8, form_weight = 6, least_form = -5, end_weight = 1, unusual = 3,
                 less_usual = 0.1;
constexpr double crown_rim = 0.4, neck_rim = 0.1;  // mean cosines
constexpr double widest_neck = 0.15, least_mask = 0.4, whole = 0.8, wide_weight = 1.5;
// Mean distances of a mirror image, as shares of the diagonal.
constexpr double most_asymmetry = 0.006, asymmetry = 0.006, mirror_weight = 4;
constexpr double broken_share = 0.25;
constexpr double certain = 0.95;
constexpr double least_named = 0.03;  // of another axis in a warning
constexpr double usual_size_mm = 300;

constexpr int bins = 8;  // a side of each face of a cube: 11 degrees

// The cell of a cube's surface in which a direction lies.
std::size_t bin_of(const Eigen::Vector3d& n) {
  Eigen::Index axis = 0;
  const double most = n.cwiseAbs().maxCoeff(&axis);
  const auto cell = [&](double x) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>((x / most + 1) / 2 * bins), 0, bins - 1));
  };
  const auto face = static_cast<std::size_t>(2 * axis + (n[axis] < 0));
  return (face * bins + cell(n[(axis + 1) % 3])) * bins + cell(n[(axis + 2) % 3]);
}

// Sharpens the direction of a flat side: the sum of what lies in its plane.
Cut sharpened(const TriangleMesh& skin, const Eigen::Vector3d& normal, double band, bool noisy) {
  Cut cut{normal, 0, false, 0};
  const double last = noisy ? 0.94 : flat_cosine;
  for (const double cosine : {0.94, std::min(0.98, last), last}) {
    double support = -HUGE_VAL;
    for (const auto& p : skin.vertices) support = std::max(support, cut.normal.dot(p));
    const double wide = cosine < flat_cosine && !noisy ? 4 * band : band;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& t : skin.triangles) {
      const Eigen::Vector3d a = area_vector(skin, t);
      bool in_plane = cut.normal.dot(a) > cosine * a.norm();
      for (const int v : t) in_plane = in_plane && cut.normal.dot(skin.vertices[v]) > support - wide;
      if (in_plane) sum += a;
    }
    cut.area = sum.norm();
    if (cut.area == 0) return cut;
    cut.normal = sum / cut.area;
  }
  return cut;
}

}  // namespace

namespace {

// How far the surface behind a plane looks to its front, as a mean cosine: 0 along a neck, 0.5 to 0.8 around a lost
// crown. A ragged border and the rest of a flat foot lie in the plane itself and do not count.
double slope_behind(const TriangleMesh& skin, const Eigen::Vector3d& normal, double plane, double size) {
  double sum = 0, total = 0;
  for (const auto& t : skin.triangles) {
    double behind = plane;
    for (const int v : t) behind -= normal.dot(skin.vertices[v]) / 3;
    if (behind < 0.015 * size || behind > 0.08 * size) continue;
    const Eigen::Vector3d a = area_vector(skin, t);
    sum += normal.dot(a);
    total += a.norm();
  }
  return total > 0 ? sum / total : 0;
}

}  // namespace

std::vector<Cut> find_cuts(const TriangleMesh& skin, double noise_mm) {
  std::vector<Eigen::Vector3d> sums(6 * bins * bins, Eigen::Vector3d::Zero());
  double total = 0;
  for (const auto& t : skin.triangles) {
    const Eigen::Vector3d a = area_vector(skin, t);
    if (a.squaredNorm() == 0) continue;
    sums[bin_of(a)] += a;
    total += a.norm();
  }
  std::vector<Cut> cuts;
  const double band = flat_band * bounds(skin).size().norm() + 4 * noise_mm;
  std::stable_sort(sums.begin(), sums.end(),
                   [](const auto& a, const auto& b) { return a.norm() > b.norm(); });
  for (std::size_t i = 0; i < 16 && sums[i].norm() > least_flat / 4 * total; ++i) {
    Cut cut = sharpened(skin, sums[i].normalized(), band, noise_mm > 0);
    if (cut.area < least_flat * total) continue;
    cut.area /= total;
    if (std::ranges::none_of(cuts, [&](const Cut& c) { return c.normal.dot(cut.normal) > 0.95; }))
      cuts.push_back(cut);
  }
  const auto loops = border_loops(skin);
  for (const auto& loop : loops) {
    const auto at = [&](std::size_t i) -> const Eigen::Vector3d& { return skin.vertices[loop[i]]; };
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    for (std::size_t i = 2; i < loop.size(); ++i) area += (at(i - 1) - at(0)).cross(at(i) - at(0)) / 2;
    if (area.norm() > least_open * total) {
      Cut cut{area.normalized(), area.norm() / total, true, 0};
      double plane = 0;
      for (const int v : loop) plane += cut.normal.dot(skin.vertices[v]) / static_cast<double>(loop.size());
      cut.rim = slope_behind(skin, cut.normal, plane, bounds(skin).size().norm());
      cuts.push_back(cut);
    }
  }
  std::stable_sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.area > b.area; });
  return cuts;
}

bool UpGuess::conclusive() const { return best().confidence >= certain && evidence >= certain; }

namespace {

// Without pieces that have less than a quarter of the area of the largest one, unless they make up half of the area.
TriangleMesh main_pieces(const TriangleMesh& skin) {
  std::vector<int> piece_of;
  const int count = connected_pieces(skin, piece_of);
  if (count < 2) return skin;
  std::vector<double> area(static_cast<std::size_t>(count), 0);
  for (std::size_t i = 0; i < piece_of.size(); ++i)
    area[piece_of[i]] += area_vector(skin, skin.triangles[i]).norm();
  const double largest = *std::max_element(area.begin(), area.end());
  std::vector<char> keep;
  double kept = 0, total = 0;
  for (const double a : area) {
    keep.push_back(a >= small_piece * largest);
    kept += keep.back() ? a : 0;
    total += a;
  }
  return kept < total / 2 ? skin : take_pieces(skin, piece_of, keep);
}

// Closed by a fan over each border that is at least `least` long, in edges.
TriangleMesh filled(TriangleMesh mesh, std::size_t least = 0) {
  for (const auto& loop : border_loops(mesh)) {
    if (loop.size() < least) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int v : loop) middle += mesh.vertices[v];
    const int hub = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(middle / static_cast<double>(loop.size()));
    for (std::size_t i = 0; i < loop.size(); ++i)
      mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], hub});
  }
  return mesh;
}

bool is_broken(const TriangleMesh& skin) {
  const auto loops = border_loops(skin);
  std::size_t edges = 0;
  for (const auto& loop : loops) edges += loop.size();
  return loops.size() > 20 && 10 * edges > skin.triangles.size();
}

// How much of a body can be formed from each axis: the height of the mold times the share of it that is a dome.
Result<std::array<double, axes.size()>> formable(const TriangleMesh& closed, const ScanProgress& progress) {
  const Box box = bounds(closed);
  const double size = box.size().norm();
  const auto caster = std::make_shared<RayCaster>(closed);
  std::array<double, axes.size()> heights{};
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const Eigen::Matrix3d turn = upright_turn(axes[k], 0, 0, 0);
    const Eigen::Vector3d up = turn.row(2);
    const double lowest = std::min(up.dot(box.low), up.dot(box.high)), height = std::abs(up.dot(box.size()));
    VACUFORM_TRY(space, CoveredSpace::measure(closed, caster, turn, lowest, pose_ray_share * size, progress));
    const double cut = space.lowest_cut(pose_depth_share * size, pose_area_share * size * size);
    heights[k] = (lowest + height - cut) * space.domed_share(cut, pose_dome_share * size);
  }
  return heights;
}

// How much a cut speaks for a foot. The rim of a lost crown looks out of its hole; a wide opening is the foot of a cap
// or a mask, which can be formed whole, or a lost crown.
double foot_weight(const Cut& cut, double formed) {
  if (!cut.open || formed > whole) return cut_weight;
  const double weight = cut_weight * std::clamp((crown_rim - cut.rim) / (crown_rim - neck_rim), 0.0, 1.0);
  return cut.area > widest_neck && cut.area < least_mask ? std::min(weight, wide_weight) : weight;
}

// The area of the end towards each axis that looks there, within an eighth of the body, at least 1 % of the box: a crown
// is broad and round, a chin is not.
std::array<double, axes.size()> end_areas(const TriangleMesh& body) {
  const Box box = bounds(body);
  std::array<double, axes.size()> areas{};
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const Eigen::Vector3d up = upright_turn(axes[k], 0, 0, 0).row(2);
    const double highest = std::max(up.dot(box.low), up.dot(box.high)), height = std::abs(up.dot(box.size()));
    for (const auto& t : body.triangles) {
      double z = 0;
      for (const int v : t) z += up.dot(body.vertices[v]) / 3;
      if (z > highest - height / 8) areas[k] += std::max(0.0, up.dot(area_vector(body, t)));
    }
    areas[k] = std::max(areas[k], 0.01 * box.size().prod() / height);
  }
  return areas;
}

}  // namespace

Result<UpGuess> guess_up(const TriangleMesh& skin, const ScanProgress& progress) {
  TriangleMesh body = main_pieces(skin);
  const double size = bounds(body).size().norm();
  UpGuess guess;
  const bool broken = is_broken(body);
  if (broken) {
    guess.cuts = find_cuts(body);
    std::erase_if(guess.cuts, [](const Cut& cut) { return !cut.open; });
    WrapBudget budget{25'000'000 + 1000 * static_cast<std::int64_t>(body.triangles.size())};
    auto wrapped = wrap(filled(body, 20), 0.04 * size, 0.001 * size, progress, budget);
    if (!wrapped && wrapped.error().code == Code::cancelled) return tl::make_unexpected(wrapped.error());
    if (wrapped) {
      body = std::move(*wrapped);
      for (const Cut& cut : find_cuts(body)) guess.cuts.push_back(cut);
    }
  } else {
    VACUFORM_TRY(smooth, without_noise(body, size / 2, progress));
    if (smooth) {  // smoothing rounds the edge of a flat side that has few triangles
      guess.cuts = find_cuts(body, noise_of(body));
      body = std::move(*smooth);
    }
    for (const Cut& cut : find_cuts(body))
      if (std::ranges::none_of(guess.cuts, [&](const Cut& c) { return c.normal.dot(cut.normal) > 0.95; }))
        guess.cuts.push_back(cut);
  }
  body = filled(std::move(body));
  VACUFORM_TRY(heights, formable(body, progress));
  const auto ends = end_areas(body);
  const double highest = *std::max_element(heights.begin(), heights.end());

  std::array<double, axes.size()> score{}, habit{};  // habit: how files usually stand
  std::array<const Cut*, axes.size()> foot{};
  bool footed = false;
  double widest_flat = 0;
  for (const Cut& cut : guess.cuts)
    if (!cut.open) widest_flat = std::max(widest_flat, cut.area);
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const Eigen::Vector3d up = upright_turn(axes[k], 0, 0, 0).row(2);
    habit[k] = axes[k] == UpAxis::plus_z ? 0 : axes[k] == UpAxis::plus_y ? -less_usual : -unusual;
    score[k] = habit[k] + std::max(least_form, form_weight * std::log(std::max(1e-3, heights[k] / highest)));
    const double formed = heights[k] / std::abs(up.dot(bounds(body).size()));
    double most = 0;
    for (const Cut& cut : guess.cuts) {
      const double down = -up.dot(cut.normal);
      // Of several flat sides, as a block has them, a body stands on the widest.
      const double share = cut.open ? 1 : std::sqrt(cut.area / widest_flat);
      const double weight = share * foot_weight(cut, formed) * std::clamp((down - 0.5) / 0.5, 0.0, 1.0);
      if (weight > most) most = weight, foot[k] = &cut;
    }
    score[k] += most;
    if (most == 0) score[k] += end_weight * std::clamp(std::log(ends[k] / ends[opposite(k)]), -1.0, 1.0);
    footed = footed || (most > cut_weight / 2);
  }
  if (!footed) {
    // In about millimetres, which a search for distances expects.
    for (auto& v : body.vertices) v *= usual_size_mm / size;
    const MirrorTest mirror(body);
    VACUFORM_TRY(plane, mirror.best(progress));
    std::array<double, axes.size()> errors{};
    double least = plane.error;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      if (opposite(k) < k) {
        errors[k] = errors[opposite(k)];
      } else {
        VACUFORM_TRY(along, mirror.best_along(upright_turn(axes[k], 0, 0, 0).row(2), progress));
        errors[k] = along.error;
      }
      least = std::min(least, errors[k]);
    }
    if (least < most_asymmetry) {
      for (std::size_t k = 0; k < axes.size(); ++k)
        score[k] -= mirror_weight * std::clamp((errors[k] - least) / asymmetry - 0.3, 0.0, 1.0);
      // A body that turns about an axis has many planes.
      if (plane.error < 0.5 * *std::min_element(errors.begin(), errors.end())) guess.side = plane.normal;
    }
  }
  if (broken)
    for (double& s : score) s *= broken_share;
  const auto first = static_cast<std::size_t>(std::max_element(score.begin(), score.end()) - score.begin());
  const double best = score[first];
  if (foot[first]) {
    double all = 0;
    for (std::size_t k = 0; k < axes.size(); ++k)
      all += std::exp((score[k] - habit[k]) - (score[first] - habit[first]));
    guess.evidence = 1 / all;
  }
  double sum = 0;
  for (double& s : score) s = std::exp(s - best), sum += s;
  for (std::size_t k = 0; k < axes.size(); ++k)
    guess.candidates.push_back({axes[k], score[k] / sum,
                                foot[k] ? foot[k]->open ? "the scan is open on the other side"
                                                        : "the scan is cut flat on the other side"
                                : heights[k] > 0.1 * size / 2 ? "much of the scan can be formed from there"
                                                              : "nothing in the scan speaks against it"});
  std::stable_sort(guess.candidates.begin(), guess.candidates.end(),
                   [](const UpCandidate& a, const UpCandidate& b) { return a.confidence > b.confidence; });
  return guess;
}

Warning up_warning(const UpGuess& guess, UpAxis used, bool told) {
  const UpCandidate& best = guess.best();
  const auto percent = [](double share) { return decimal(100 * share, 0) + " %"; };
  Warning warning{"up-guessed",
                  told ? "The up axis is " + std::string(name(used)) + ", as the format says, but " +
                             std::string(name(best.axis)) + " looks right because " + best.why
                       : "The up axis was taken to be " + std::string(name(used)) + " because " + best.why +
                             ", but its confidence is only " + percent(best.confidence)};
  for (const UpCandidate& c : guess.candidates)
    if (c.axis != used && (warning.proposals.empty() || c.confidence >= least_named))
      warning.proposals.push_back({{{"scan.up", name(c.axis)}}, percent(c.confidence) + ", " + c.why});
  warning.fix = "Look at the mold, and turn it if it stands wrong.";
  warning.figure = Warning::Figure{100 * (told ? 1 - best.confidence : best.confidence), "%", 100 * certain};
  return warning;
}

namespace {

// The turn that brings `up` to the ceiling, if it is more than the limit.
std::optional<Tilt> tilt_of(const Eigen::Vector3d& up, Tilt::Of of) {
  constexpr double degree = std::numbers::pi / 180;
  const auto tenths = [](double radians) { return std::round(10 * radians / degree) / 10 + 0.0; };
  const Tilt tilt{std::atan2(std::hypot(up.x(), up.y()), up.z()) / degree, tenths(std::atan2(up.y(), up.z())),
                  tenths(-std::atan2(up.x(), std::hypot(up.y(), up.z()))), of};
  return tilt.angle_deg > tilt.limit_deg() ? std::optional(tilt) : std::nullopt;
}

}  // namespace

std::optional<Tilt> find_tilt(const UpGuess& guess, const Eigen::Matrix3d& stood) {
  for (const Cut& cut : guess.cuts) {
    const Eigen::Vector3d up = -(stood * cut.normal);
    if (up.z() > 0.5) return tilt_of(up, cut.open ? Tilt::Of::opening : Tilt::Of::flat_side);
  }
  if (!guess.side) return std::nullopt;
  const Eigen::Vector3d side = stood * *guess.side;
  if (std::abs(side.z()) > 0.9) return std::nullopt;  // the head lies on its side: up is wrong
  return tilt_of((Eigen::Vector3d::UnitZ() - side.z() * side).normalized(), Tilt::Of::median_plane);
}

}  // namespace vacuform
