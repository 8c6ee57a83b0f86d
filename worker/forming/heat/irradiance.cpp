#include "worker/forming/heat/irradiance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "worker/forming/heat/view_factor.hpp"
#include "worker/scan/ray_caster.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int rays_an_octant = 64;
constexpr int most_reflections = 64;
constexpr double lost_weight = 1e-3;  // a ray that carries less is not followed on

double fourth_power(double celsius) { return std::pow(celsius - absolute_zero, 4); }

double base_two_inverse(unsigned i) {  // van der Corput's sequence
  double value = 0, digit = 0.5;
  for (; i; i >>= 1, digit /= 2)
    if (i & 1) value += digit;
  return value;
}

// Directions over a small element, as dense as the cosine of their angle to its normal: Hammersley points in one octant
// of the disc, mirrored into the others, raised to the half sphere (Malley's method).
std::vector<Vector3d> cosine_directions() {
  std::vector<Vector3d> directions;
  for (unsigned i = 0; i < rays_an_octant; ++i) {
    const double radius = std::sqrt((i + 0.5) / rays_an_octant);
    const double angle = std::numbers::pi / 4 * (base_two_inverse(i) + 0.5 / rays_an_octant);
    const double a = radius * std::cos(angle), b = radius * std::sin(angle);
    const double up = std::sqrt(1 - radius * radius);
    for (const auto& [x, y] : {std::pair(a, b), std::pair(b, a)})
      for (const double sx : {-1.0, 1.0})
        for (const double sy : {-1.0, 1.0}) directions.emplace_back(sx * x, sy * y, up);
  }
  return directions;
}

void add_upright(TriangleMesh& mesh, const Vector2d& a, const Vector2d& b, double low, double high) {
  const int v = static_cast<int>(mesh.vertices.size());
  for (const double z : {low, high})
    for (const Vector2d& p : {a, b}) mesh.vertices.emplace_back(p.x(), p.y(), z);
  mesh.triangles.push_back({v, v + 1, v + 3});
  mesh.triangles.push_back({v, v + 3, v + 2});
}

std::vector<Vector2d> outline_of_window(const MachineSettings& machine) {
  const double w = machine.window_width_mm / 2, h = machine.window_height_mm / 2;
  if (machine.window == WindowShape::rectangle) return {{-w, -h}, {w, -h}, {w, h}, {-w, h}};
  std::vector<Vector2d> circle;
  for (int i = 0; i < 180; ++i) {
    const double angle = i * std::numbers::pi / 90;
    circle.emplace_back(w * std::cos(angle), w * std::sin(angle));
  }
  return circle;
}

}  // namespace

// The reflectors come first in the mesh, two triangles a wall, in the order of `axis` and `at`; then the lip.
struct Irradiance::Walls {
  static constexpr std::array<int, 4> axis{0, 0, 1, 1};
  std::array<double, 4> at{};  // the wall's coordinate on its axis
  int reflectors = 0;          // 0 or 4
  double reflectance = 0;
  TriangleMesh mesh;
  RayCaster rays{TriangleMesh{}};
  std::vector<Vector3d> directions = cosine_directions();
};

Irradiance::~Irradiance() = default;
Irradiance::Irradiance(Irradiance&&) noexcept = default;

Irradiance::Irradiance(const MachineSettings& machine, const HeatSettings& heat, Side side) {
  const double sign = side == Side::above ? 1 : -1;
  for (const Heater& h : machine.heaters) {
    if (sign * h.z_mm <= 0) continue;
    const double area_m2 = h.width_mm * h.height_mm / 1e6;
    const double full = h.power_w ? *h.power_w / area_m2
                                  : h.emissivity * stefan_boltzmann *
                                        (fourth_power(*h.celsius) - fourth_power(heat.ambient_c));
    const auto gain = heat.gains.find(h.zone);
    panels_.push_back({h.x_mm - h.width_mm / 2, h.x_mm + h.width_mm / 2, h.y_mm - h.height_mm / 2,
                       h.y_mm + h.height_mm / 2, sign * h.z_mm,
                       full * (gain == heat.gains.end() ? 1.0 : gain->second)});
  }
  std::stable_sort(panels_.begin(), panels_.end(),
                   [](const Panel& a, const Panel& b) { return a.height < b.height; });
  if (panels_.empty() || (machine.reflector_mm == 0 && machine.lip_mm == 0)) return;

  walls_ = std::make_unique<Walls>();
  if (machine.reflector_mm > 0) {
    double x0 = panels_[0].x0, x1 = panels_[0].x1, y0 = panels_[0].y0, y1 = panels_[0].y1;
    for (const Panel& p : panels_)
      x0 = std::min(x0, p.x0), x1 = std::max(x1, p.x1), y0 = std::min(y0, p.y0), y1 = std::max(y1, p.y1);
    const double high = panels_.back().height, low = std::max(0.0, high - machine.reflector_mm);
    walls_->reflectors = 4;
    walls_->reflectance = machine.reflectance;
    walls_->at = {x0, x1, y0, y1};
    add_upright(walls_->mesh, {x0, y0}, {x0, y1}, low, high);
    add_upright(walls_->mesh, {x1, y0}, {x1, y1}, low, high);
    add_upright(walls_->mesh, {x0, y0}, {x1, y0}, low, high);
    add_upright(walls_->mesh, {x0, y1}, {x1, y1}, low, high);
  }
  if (machine.lip_mm > 0) {
    const auto outline = outline_of_window(machine);
    for (std::size_t i = 0; i < outline.size(); ++i)
      add_upright(walls_->mesh, outline[i], outline[(i + 1) % outline.size()], 0, machine.lip_mm);
  }
  walls_->rays = RayCaster(walls_->mesh);
}

double Irradiance::above_surroundings(const Vector2d& place) const {
  double sum = 0;
  for (const Panel& p : panels_)
    sum += p.radiosity *
           view_factor(p.x0 - place.x(), p.x1 - place.x(), p.y0 - place.y(), p.y1 - place.y(), p.height);
  return walls_ ? by_rays(place, sum) : sum;
}

const Irradiance::Panel* Irradiance::panel_met(const Vector3d& from, const Vector3d& way,
                                               double limit) const {
  double height = -1, x = 0, y = 0;
  for (const Panel& p : panels_) {
    if (p.height > limit) break;
    if (p.height <= from.z()) continue;
    if (p.height != height) {  // most panels lie in one plane
      height = p.height;
      const double t = (height - from.z()) / way.z();
      x = from.x() + t * way.x(), y = from.y() + t * way.y();
    }
    if (x >= p.x0 && x <= p.x1 && y >= p.y0 && y <= p.y1) return &p;
  }
  return nullptr;
}

// Over the mirrors to where the ray ends.
double Irradiance::follow(Vector3d from, Vector3d way) const {
  const Walls& walls = *walls_;
  const double far = 2 * panels_.back().height;  // beyond every heater
  double weight = 1;
  for (int reflections = 0; reflections <= most_reflections && weight > lost_weight; ++reflections) {
    const Vector3d whole = way * ((far - from.z()) / way.z());
    const auto hit = walls.rays.first_hit(from, whole);
    if (const Panel* p = panel_met(from, way, hit ? from.z() + hit->t * whole.z() : far))
      return weight * p->radiosity;
    if (!hit || hit->triangle >= 2 * walls.reflectors) return 0;
    const auto wall = static_cast<std::size_t>(hit->triangle / 2);
    const int axis = Walls::axis[wall];
    const bool from_within = wall % 2 == 0 ? from[axis] > walls.at[wall] : from[axis] < walls.at[wall];
    if (!from_within) return 0;  // the back of a reflector
    weight *= walls.reflectance;
    from += hit->t * whole;
    way[axis] = -way[axis];
    from[axis] = walls.at[wall] + std::copysign(1e-3, way[axis]);  // off the wall, exactly
  }
  return 0;
}

// Each ray is followed twice: over the walls to where it really ends, and as if nothing stood around, whose mean is known
// exactly. The second is the control variate of the first, with the coefficient of least variance: a place that sees no
// wall gets the exact sum, and one in a closed box of perfect mirrors exactly what the heater radiates.
double Irradiance::by_rays(const Vector2d& place, double exact_without) const {
  double sum_with = 0, sum_without = 0, product = 0, square = 0;
  for (const Vector3d& direction : walls_->directions) {
    const Vector3d from(place.x(), place.y(), 0);
    const Panel* p = panel_met(from, direction, std::numeric_limits<double>::infinity());
    const double without = p ? p->radiosity : 0, with = follow(from, direction);
    sum_with += with;
    sum_without += without;
    product += with * without;
    square += without * without;
  }
  const double n = static_cast<double>(walls_->directions.size());
  const double variance = square - sum_without * sum_without / n;
  const double covariance = product - sum_with * sum_without / n;
  const double coefficient = variance > 1e-12 * square ? covariance / variance : 1;
  return sum_with / n + coefficient * (exact_without - sum_without / n);
}

}  // namespace vacuform
