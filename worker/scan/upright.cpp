#include "worker/scan/upright.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "api/base/decimal.hpp"
#include "worker/scan/placing.hpp"

namespace vacuform {
namespace {

constexpr double shortest_mm = 80, longest_mm = 400;
constexpr double possible_share =
    2.54;  // beyond these sizes: a figurine or a large bust, taken in the wrong unit
constexpr std::array units{Unit::mm, Unit::cm, Unit::m, Unit::in};

std::string one_digit(double mm) { return decimal(mm, mm < 10 ? 1 : 0); }

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

Eigen::Matrix3d turn_before_front(const ScanSettings& settings, UpAxis up) {
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (settings.mirror == Mirror::yes) mirror(0, 0) = -1;
  return upright_turn(UpAxis::plus_z, settings.roll_deg, settings.pitch_deg, 0) * mirror *
         upright_turn(up, 0, 0, 0);
}

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
