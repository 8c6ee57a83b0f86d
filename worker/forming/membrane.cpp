#include "worker/forming/membrane.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace vacuform {

namespace {

// W = c1 (I1 - 3) + c2 (I2 - 3) with l3 = 1 / (l1 l2) and c1 + c2 = 1/2 (shear modulus 1). The sources of c2 / c1 = 1/4 are
// in docs/explain/physics.md: from 0.214 on, the pressure in a balloon never falls.
struct Coefficients {
  double c1, c2;
};
Coefficients coefficients(MembraneLaw law) {
  return law == MembraneLaw::neo_hookean ? Coefficients{0.5, 0.0} : Coefficients{0.4, 0.1};
}

Density plane_stress(Coefficients c, double a, double b) {
  const double a2 = a * a, b2 = b * b, ia2 = 1 / a2, ib2 = 1 / b2, i = ia2 * ib2;
  Density d{};
  d.W = c.c1 * (a2 + b2 + i - 3) + c.c2 * (ia2 + ib2 + a2 * b2 - 3);
  d.W1 = 2 * c.c1 * (a - i / a) + 2 * c.c2 * (a * b2 - ia2 / a);
  d.W2 = 2 * c.c1 * (b - i / b) + 2 * c.c2 * (b * a2 - ib2 / b);
  d.W11 = 2 * c.c1 * (1 + 3 * i * ia2) + 2 * c.c2 * (b2 + 3 * ia2 * ia2);
  d.W22 = 2 * c.c1 * (1 + 3 * i * ib2) + 2 * c.c2 * (a2 + 3 * ib2 * ib2);
  d.W12 = 4 * c.c1 * i / (a * b) + 4 * c.c2 * a * b;
  return d;
}

// Uniaxial tension with free width: l2 = l3 = l^(-1/2); nothing at all when l < 1.
Density uniaxial(Coefficients c, double l) {
  Density d{};
  if (l <= 1) return d;
  const double i = 1 / l, i2 = i * i;
  d.W = c.c1 * (l * l + 2 * i - 3) + c.c2 * (2 * l + i2 - 3);
  d.W1 = 2 * c.c1 * (l - i2) + 2 * c.c2 * (1 - i2 * i);
  d.W11 = 2 * c.c1 * (1 + 2 * i2 * i) + 6 * c.c2 * i2 * i2;
  return d;
}

// C = F'F as (c11, c12, c22), its principal stretches l1 >= l2 and the gap of their squares.
struct Principal {
  double c11, c12, c22, l1, l2, gap;
};
Principal principal(const Eigen::Matrix<double, 3, 2>& F) {
  Principal q{};
  q.c11 = F.col(0).squaredNorm(), q.c12 = F.col(0).dot(F.col(1)), q.c22 = F.col(1).squaredNorm();
  const double half = 0.5 * (q.c11 - q.c22), radius = std::sqrt(half * half + q.c12 * q.c12);
  q.gap = 2 * radius;
  q.l1 = std::max(std::sqrt(0.5 * (q.c11 + q.c22) + radius), 1e-6);
  // The product of the stretches is the area ratio: exact where a difference of their squares would cancel.
  q.l2 = std::max(F.col(0).cross(F.col(1)).norm() / q.l1, 1e-6);
  return q;
}

// The symmetric matrix (m11, m12, m22) that has the value `first` along the principal direction of l1 and `second`
// across it, by the spectral projectors of C.
Eigen::Vector3d along_principal(const Principal& q, double first, double second) {
  if (q.gap < 1e-12 * q.l1 * q.l1) return {first, 0, first};
  const double k = (first - second) / q.gap, shift = second - k * q.l2 * q.l2;
  return {k * q.c11 + shift, k * q.c12, k * q.c22 + shift};
}

}  // namespace

Density density(MembraneLaw law, double l1, double l2) {
  const Coefficients c = coefficients(law);
  const Density full = plane_stress(c, l1, l2);
  if (l2 * l2 * l1 >= 1 && l1 >= 1) return full;
  Density d = uniaxial(c, l1);
  constexpr double e = Membrane::wrinkled_stiffness;
  d.W = (1 - e) * d.W + e * full.W;
  d.W1 = (1 - e) * d.W1 + e * full.W1;
  d.W2 = e * full.W2;
  d.W11 = (1 - e) * d.W11 + e * full.W11;
  d.W22 = e * full.W22;
  d.W12 = e * full.W12;
  d.wrinkled = true;
  return d;
}

Membrane::Membrane(const std::vector<Eigen::Vector2d>& rest, const std::vector<Triangle>& triangles,
                   MembraneLaw law, std::vector<double> stiffness)
    : triangles_(triangles),
      stiffness_(std::move(stiffness)),
      law_(law),
      c1_(coefficients(law).c1),
      c2_(coefficients(law).c2) {
  shape_.resize(triangles_.size());
  area_.resize(triangles_.size());
  for (int k = 0; k < static_cast<int>(triangles_.size()); ++k) reshape(k, rest);
}

void Membrane::reshape(int triangle, const std::vector<Eigen::Vector2d>& rest) {
  const Triangle& t = triangles_[triangle];
  Eigen::Matrix2d D;
  D << rest[t[1]] - rest[t[0]], rest[t[2]] - rest[t[0]];
  const Eigen::Matrix2d inverse = D.inverse();
  Eigen::Matrix<double, 2, 3> g;
  g.col(1) = inverse.row(0).transpose();
  g.col(2) = inverse.row(1).transpose();
  g.col(0) = -g.col(1) - g.col(2);
  if (!flowed_.empty()) g = flowed_[triangle] * g;
  shape_[triangle] = g;
  area_[triangle] = 0.5 * D.determinant();
}

Eigen::Matrix<double, 3, 2> Membrane::deformation(const Points& x, int triangle) const {
  const Triangle& t = triangles_[triangle];
  const auto& g = shape_[triangle];
  return (x.col(t[1]) - x.col(t[0])) * g.col(1).transpose() +
         (x.col(t[2]) - x.col(t[0])) * g.col(2).transpose();
}

double Membrane::energy(const Points& x, double p, Points& gradient) const {
  gradient.setZero();
  double sum = 0;
  for (int k = 0; k < static_cast<int>(triangles_.size()); ++k) {
    const Triangle& t = triangles_[k];
    const auto& g = shape_[k];
    const Eigen::Matrix<double, 3, 2> F = deformation(x, k);
    const Principal q = principal(F);
    const Density d = density(law_, q.l1, q.l2);
    const Eigen::Vector3d S = along_principal(q, d.W1 / q.l1, d.W2 / q.l2);  // second Piola-Kirchhoff stress
    const double weight = stiffness_[k] * area_[k];
    const Eigen::Vector3d P1 = weight * (S[0] * F.col(0) + S[1] * F.col(1)),
                          P2 = weight * (S[1] * F.col(0) + S[2] * F.col(1));
    const Eigen::Vector3d a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]), normal = (b - a).cross(c - a);
    for (int corner = 0; corner < 3; ++corner)
      gradient.col(t[corner]) += g(0, corner) * P1 + g(1, corner) * P2 + (p / 6) * normal;
    sum += weight * d.W + p / 6 * normal.z() * (a.z() + b.z() + c.z());
  }
  return sum;
}

std::array<Eigen::Vector3d, 2> Membrane::stiffness(const Points& x, int triangle) const {
  const Principal q = principal(deformation(x, triangle));
  const Density d = density(law_, q.l1, q.l2);
  const double shear = std::max(0.0, q.gap > 1e-6 * q.l1 * q.l1 ? (q.l1 * d.W1 - q.l2 * d.W2) / q.gap
                                                                : 0.5 * (d.W11 + d.W1 / q.l1 - d.W12));
  constexpr double least_tangential = 1e-2, least_normal = 1e-3;
  return {stiffness_[triangle] * along_principal(q, std::max(least_tangential, (d.W11 + shear) / 2),
                                                 std::max(least_tangential, (d.W22 + shear) / 2)),
          stiffness_[triangle] *
              along_principal(q, std::max(least_normal, d.W1 / q.l1), std::max(least_normal, d.W2 / q.l2))};
}

void Membrane::flow(const Points& x, int triangle, double kept) {
  const Principal q = principal(deformation(x, triangle));
  // F = R U: the new rest shape takes U^(1 - kept), so that U^kept remains.
  const Eigen::Vector3d u = along_principal(q, std::pow(q.l1, kept - 1), std::pow(q.l2, kept - 1));
  Eigen::Matrix2d taken;
  taken << u[0], u[1], u[1], u[2];
  if (flowed_.empty()) flowed_.assign(triangles_.size(), Eigen::Matrix2d::Identity());
  shape_[triangle] = taken * shape_[triangle];
  flowed_[triangle] = taken * flowed_[triangle];
}

namespace {

double von_mises(MembraneLaw law, double l1, double l2) {
  const Density d = density(law, l1, l2);
  const double s1 = l1 * d.W1, s2 = l2 * d.W2;
  return std::sqrt(s1 * s1 - s1 * s2 + s2 * s2);
}

}  // namespace

double Membrane::equivalent_stress(const Points& x, int triangle) const {
  const Principal q = principal(deformation(x, triangle));
  return stiffness_[triangle] * von_mises(law_, q.l1, q.l2);
}

double Membrane::kept_at_stress(const Points& x, int triangle, double stress) const {
  const Principal q = principal(deformation(x, triangle));
  const double wanted = stress / stiffness_[triangle];
  if (von_mises(law_, q.l1, q.l2) <= wanted) return 1;
  double low = 0, high = 1;  // the stress grows with the power
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (von_mises(law_, std::pow(q.l1, middle), std::pow(q.l2, middle)) > wanted ? high : low) = middle;
  }
  return low;
}

double Membrane::area_stretch(const Points& x, int triangle) const {
  const Triangle& t = triangles_[triangle];
  const Eigen::Vector3d a = x.col(t[0]), e1 = x.col(t[1]) - a, e2 = x.col(t[2]) - a;
  return 0.5 * e1.cross(e2).norm() / area_[triangle];
}

bool Membrane::wrinkled(const Points& x, int triangle) const {
  const Principal q = principal(deformation(x, triangle));
  return q.l1 > 1.001 && q.l2 * q.l2 * q.l1 < 0.99;
}

}  // namespace vacuform
