#include "worker/scan/upright.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "api/base/decimal.hpp"
#include "worker/scan/placing.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double shortest_mm = 80, longest_mm = 400;
constexpr double possible_share =
    2.54;  // beyond these sizes: a figurine or a large bust, taken in the wrong unit
constexpr double least_opening = 0.12;  // of the box seen from below; a neck has a quarter
constexpr double other_flat =
    0.5;  // of the largest flat side: with another one this large, both may be the foot
constexpr std::array units{Unit::mm, Unit::cm, Unit::m, Unit::in};

std::string one_digit(double mm) { return decimal(mm, mm < 10 ? 1 : 0); }

Eigen::Vector3d direction(UpAxis axis) {
  switch (axis) {
    case UpAxis::plus_x:
      return {1, 0, 0};
    case UpAxis::minus_x:
      return {-1, 0, 0};
    case UpAxis::plus_y:
      return {0, 1, 0};
    case UpAxis::minus_y:
      return {0, -1, 0};
    case UpAxis::minus_z:
      return {0, 0, -1};
    case UpAxis::plus_z:
    case UpAxis::automatic:
      return {0, 0, 1};
  }
  return {0, 0, 1};
}

constexpr std::array axes{UpAxis::plus_z,  UpAxis::plus_y, UpAxis::minus_z,
                          UpAxis::minus_y, UpAxis::plus_x, UpAxis::minus_x};

}  // namespace

double millimetres(Unit unit) {
  switch (unit) {
    case Unit::cm:
      return 10;
    case Unit::m:
      return 1000;
    case Unit::in:
      return 25.4;
    case Unit::mm:
    case Unit::automatic:
      return 1;
  }
  return 1;
}

bool usable_side(double mm) { return mm >= 10 && mm <= 4000; }

Result<Unit> guess_unit(double longest_side, const std::string& where) {
  std::vector<Unit> fitting;
  std::string all, candidates;
  for (const Unit unit : units) {
    const double mm = longest_side * millimetres(unit);
    const std::string text = std::string(name(unit)) + " (" + one_digit(mm) + " mm)";
    all += (all.empty() ? "" : ", ") + text;
    if (mm < shortest_mm || mm > longest_mm) continue;
    fitting.push_back(unit);
    candidates += (candidates.empty() ? "" : ", ") + text;
  }
  if (fitting.size() == 1) return fitting.front();
  const std::string what =
      fitting.empty() ? "the scan's unit is not clear: in none is its longest side 80 to 400 mm: " + all
                      : "the scan's unit is not clear: its longest side is plausible in " + candidates;
  // The fix must name a setting that is accepted.
  Unit nearest = units.front();  // to a head's 200 mm, as a ratio
  for (const Unit unit : units)
    if (std::abs(std::log(longest_side * millimetres(unit) / 200)) <
        std::abs(std::log(longest_side * millimetres(nearest) / 200)))
      nearest = unit;
  std::string fix = "say which, for example --set scan.units=";
  if (!fitting.empty()) {
    fix += name(fitting.front());
  } else {
    fix = "say how large it is, for example --set scan.size_mm=200 for its longest side";
    if (usable_side(longest_side * millimetres(nearest)))
      fix += ", or its unit, for example --set scan.units=" + std::string(name(nearest));
  }
  return fail(Code::ambiguous_units, what, where, fix);
}

std::string unit_doubt(double longest_side, Unit guessed) {
  std::string others;
  for (const Unit unit : units) {
    const double mm = longest_side * millimetres(unit);
    if (unit != guessed && mm >= shortest_mm / possible_share && mm <= longest_mm * possible_share)
      others += (others.empty() ? "" : " or ") + std::string(name(unit)) + " (" + one_digit(mm) + " mm)";
  }
  if (others.empty()) return {};
  return "The unit was taken to be " + std::string(name(guessed)) + ", in which the longest side is " +
         one_digit(longest_side * millimetres(guessed)) + " mm; it could be " + others;
}

namespace {

// What the borders of an open skin show: the area vectors of the faces that are missing.
struct Borders {
  std::size_t count = 0, edges = 0;
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
};

Borders borders_of(const TriangleMesh& skin) {
  Borders borders;
  for (const auto& loop : border_loops(skin)) {
    const auto at = [&](std::size_t i) -> const Eigen::Vector3d& {
      return skin.vertices[static_cast<std::size_t>(loop[i])];
    };
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    for (std::size_t i = 2; i < loop.size(); ++i) area += (at(i - 1) - at(0)).cross(at(i) - at(0)) / 2;
    ++borders.count;
    borders.edges += loop.size();
    if (area.norm() > borders.largest.norm()) borders.largest = area;
  }
  return borders;
}

Result<UpGuess> guess_of_closed(const TriangleMesh& skin, double total, const ScanProgress& progress);

}  // namespace

Result<UpGuess> guess_up(const TriangleMesh& skin, const ScanProgress& progress) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0;
  for (const auto& t : skin.triangles) {
    const Eigen::Vector3d a = area_vector(skin, t);
    sum += a;
    total += a.norm();
  }
  const Borders borders = borders_of(skin);
  // An opening that spans an angle of t from a sphere's middle leaves sin^2(t) / 4 of the area: 1.5 % at 14 degrees.
  // Its missing face must point against the sum, because many small holes can leave such a sum by chance.
  const bool open = sum.norm() > 0.015 * total && -borders.largest.dot(sum) > 0.8 * sum.squaredNorm();
  // It must also be a large part of the body seen from below. The hole that an arm leaves is not.
  const auto below = [&](UpAxis axis) {
    const Eigen::Vector3d up = direction(axis), size = bounds(skin).size();
    const double footprint = size.prod() / std::abs(up.dot(size));
    return -up.dot(borders.largest) / footprint;
  };
  const bool broken = borders.count > 20 && 10 * borders.edges > skin.triangles.size();
  UpGuess best;
  double most = 0;
  for (const UpAxis axis : axes)
    if (const double along = direction(axis).dot(sum); along > most) most = along, best.axis = axis;
  if (open && below(best.axis) > least_opening) {
    best.conclusive = !broken;
    best.why = "the scan is open on the other side";
    return best;
  }
  if (broken) {
    WrapBudget budget{25'000'000 + 1000 * static_cast<std::int64_t>(skin.triangles.size())};
    const double size = bounds(skin).size().norm();
    auto wrapped = wrap(skin, 0.04 * size, 0.001 * size, progress, budget);
    if (!wrapped && wrapped.error().code == Code::cancelled) return tl::make_unexpected(wrapped.error());
    if (wrapped) {
      double area = 0;
      for (const auto& t : wrapped->triangles) area += area_vector(*wrapped, t).norm();
      VACUFORM_TRY(guess, guess_of_closed(*wrapped, area, progress));
      guess.conclusive = false;
      return guess;
    }
  }
  return guess_of_closed(skin, total, progress);
}

namespace {

Result<UpGuess> guess_of_closed(const TriangleMesh& skin, double total, const ScanProgress& progress) {
  const Box box = bounds(skin);
  UpGuess best;
  std::array<double, axes.size()> flat{};
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const Eigen::Vector3d up = direction(axes[k]);
    const double lowest = std::min(up.dot(box.low), up.dot(box.high)), band = 0.004 * box.size().norm();
    for (const auto& t : skin.triangles) {
      const Eigen::Vector3d a = area_vector(skin, t);
      if (-up.dot(a) < 0.99 * a.norm()) continue;
      bool low = true;
      for (const int v : t) low = low && up.dot(skin.vertices[static_cast<std::size_t>(v)]) < lowest + band;
      if (low) flat[k] += a.norm();
    }
  }
  const double flattest = *std::max_element(flat.begin(), flat.end());
  const bool on_flat = flattest > 0.02 * total;
  const auto may_be_foot = [&](std::size_t k) { return !on_flat || flat[k] > other_flat * flattest; };
  std::size_t feet = 0;
  for (std::size_t k = 0; k < axes.size(); ++k)
    if (on_flat && may_be_foot(k)) ++feet, best.axis = axes[k];
  if (feet == 1) {
    best.conclusive = true;
    best.why = "the scan is cut flat on the other side";
    return best;
  }
  // Coarse rays are enough: the results differ by tens of millimetres on a head, and in proportion on anything larger.
  const double size = box.size().norm() / 250;
  const auto caster = std::make_shared<RayCaster>(skin);
  double highest = 0;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (!may_be_foot(k)) continue;
    const UpAxis axis = axes[k];
    const Eigen::Vector3d up = direction(axis);
    const double lowest = std::min(up.dot(box.low), up.dot(box.high)), height = std::abs(up.dot(box.size()));
    VACUFORM_TRY(
        space, CoveredSpace::measure(skin, caster, upright_turn(axis, 0, 0, 0), lowest, 2 * size, progress));
    const double cut = space.lowest_cut(size, 20 * size * size);
    const bool usual = axis == UpAxis::plus_z || axis == UpAxis::plus_y;
    const double left = (lowest + height - cut) * space.domed_share(cut, 10 * size) * (usual ? 1.2 : 1.0);
    if (left > highest) highest = left, best.axis = axis;
  }
  if (highest >= 0.1 * box.size().maxCoeff()) {
    best.why = on_flat ? "of the scan's flat sides, most of it can be formed over that one"
                       : "most of the scan can be formed from there";
    return best;
  }
  best.axis = UpAxis::plus_z;
  best.why = "nothing in the scan shows it";
  return best;
}

}  // namespace

namespace {

// Up, mirrored in x = 0, roll and pitch: all that comes before the front.
Eigen::Matrix3d turn_before_front(const ScanSettings& settings, UpAxis up) {
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (settings.mirror == Mirror::yes) mirror(0, 0) = -1;
  return upright_turn(UpAxis::plus_z, settings.roll_deg, settings.pitch_deg, 0) * mirror *
         upright_turn(up, 0, 0, 0);
}

}  // namespace

std::optional<FrontSide> front_of_gltf(const ScanSettings& settings, UpAxis up) {
  const Eigen::Vector3d front = turn_before_front(settings, up).col(2);
  const double x = std::abs(front.x()), y = std::abs(front.y());
  if (std::max(x, y) == 0 || std::abs(front.z()) > std::hypot(x, y)) return std::nullopt;
  if (x > y) return front.x() > 0 ? FrontSide::plus_x : FrontSide::minus_x;
  return front.y() > 0 ? FrontSide::plus_y : FrontSide::minus_y;
}

Eigen::Matrix3d scan_turn(const ScanSettings& settings, UpAxis up) {
  Eigen::Matrix3d front = Eigen::Matrix3d::Identity();
  switch (settings.front) {
    case FrontSide::plus_x:
      front << 0, -1, 0, 1, 0, 0, 0, 0, 1;
      break;
    case FrontSide::minus_x:
      front << 0, 1, 0, -1, 0, 0, 0, 0, 1;
      break;
    case FrontSide::minus_y:
      front << -1, 0, 0, 0, -1, 0, 0, 0, 1;
      break;
    case FrontSide::plus_y:
    case FrontSide::automatic:
      break;
  }
  return upright_turn(UpAxis::plus_z, 0, 0, settings.yaw_deg) * front * turn_before_front(settings, up);
}

Eigen::Matrix3d upright_turn(UpAxis up, double roll_deg, double pitch_deg, double yaw_deg) {
  constexpr double radian = std::numbers::pi / 180;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  switch (up) {  // exact quarter turns, so that a scan that stands upright is not touched
    case UpAxis::plus_y:
      turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case UpAxis::minus_y:
      turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
    case UpAxis::plus_x:
      turn << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case UpAxis::minus_x:
      turn << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case UpAxis::minus_z:
      turn << 1, 0, 0, 0, -1, 0, 0, 0, -1;
      break;
    case UpAxis::plus_z:
    case UpAxis::automatic:
      break;
  }
  const auto about = [&](double degrees, const Eigen::Vector3d& axis) -> Eigen::Matrix3d {
    if (degrees == 0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(degrees * radian, axis).toRotationMatrix();
  };
  return turn_about_z(yaw_deg * radian) * about(pitch_deg, Eigen::Vector3d::UnitY()) *
         about(roll_deg, Eigen::Vector3d::UnitX()) * turn;
}

}  // namespace vacuform
