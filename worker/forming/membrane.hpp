// The membrane: linear triangles, plane stress, incompressible, under the pressure of a vacuum on one face.
//
// The energy is that of Pipkin's relaxed membrane ("The relaxed energy density for isotropic elastic membranes",
// IMA J. Appl. Math. 1986): a triangle that is compressed across its tension wrinkles and carries tension only, so
// the energy stays convex where a sheet webs. A small part `wrinkled_stiffness` of the unrelaxed energy is kept there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "api/settings.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

using Points = Eigen::Matrix<double, 3, Eigen::Dynamic>;  // one column a vertex, mm

// Energy density per rest area and shear modulus, as a function of the principal stretches l1 >= l2 > 0.
struct Density {
  double W, W1, W2;      // value and first derivatives
  double W11, W22, W12;  // second derivatives
  bool wrinkled;         // l2 below the natural width of the tension l1
};
Density density(MembraneLaw law, double l1, double l2);

class Membrane {
 public:
  // Lengths in mm. Energies are in units of (shear modulus x thickness x mm^2), so only pressure has a unit: p is
  // given as pressure / (shear modulus x thickness), 1/mm. `stiffness` is each triangle's modulus over that one.
  Membrane(const std::vector<Eigen::Vector2d>& rest, const std::vector<Triangle>& triangles, MembraneLaw law,
           std::vector<double> stiffness);

  std::size_t triangle_count() const { return triangles_.size(); }

  // The energy of the sheet, elastic plus p times the volume under it, and its gradient at the vertices (3 x vertices,
  // overwritten). The pressure pushes against the normal that counter-clockwise triangles show.
  double energy(const Points& x, double p, Points& gradient) const;

  // The stiffness against moving one vertex in the sheet's plane, and along its normal (by tension alone): the
  // coefficients (t11, t12, t22) of a scalar form in the triangle's rest frame, symmetric positive definite, per
  // rest area. Means over the directions in the plane, with a small least value where the sheet is wrinkled.
  std::array<Eigen::Vector3d, 2> stiffness(const Points& x, int triangle) const;
  // Gradient of the three shape functions of a triangle in the rest plane, 1/mm (columns), and its rest area, mm^2.
  const Eigen::Matrix<double, 2, 3>& shape_gradient(int triangle) const { return shape_[triangle]; }
  double rest_area(int triangle) const { return area_[triangle]; }
  // Shear modulus of a triangle over that of the sheet, and the coefficients c1, c2 of
  // W = c1 (I1 - 3) + c2 (I2 - 3).
  double modulus(int triangle) const { return stiffness_[triangle]; }
  double c1() const { return c1_; }
  double c2() const { return c2_; }
  // The part of the unrelaxed energy that is kept where the sheet wrinkles.
  static constexpr double wrinkled_stiffness = 1e-3;

  // Gives a triangle other corners on the flat sheet; what has flowed stays.
  void reshape(int triangle, const std::vector<Eigen::Vector2d>& rest);

  // Lets a triangle flow: its rest shape follows its shape at x until only the power `kept` (0: nothing, 1: all) of its
  // principal stretches is left. Its volume stays that of the flat sheet.
  void flow(const Points& x, int triangle, double kept);
  // The equivalent stress (von Mises) in a triangle over its shear modulus.
  double equivalent_stress(const Points& x, int triangle) const;
  // The power of its principal stretches at which a triangle has that equivalent stress: 1 where it has no more.
  double kept_at_stress(const Points& x, int triangle, double stress) const;

  // Formed area over rest area, and whether the triangle is wrinkled: stretched, and half a per cent narrower than that
  // tension alone would make it.
  double area_stretch(const Points& x, int triangle) const;
  bool wrinkled(const Points& x, int triangle) const;

 private:
  Eigen::Matrix<double, 3, 2> deformation(const Points& x, int triangle) const;

  std::vector<Triangle> triangles_;
  std::vector<Eigen::Matrix<double, 2, 3>> shape_;
  std::vector<double> area_;
  std::vector<Eigen::Matrix2d>
      flowed_;  // of each triangle: its shape gradients over those of the flat sheet; or empty
  std::vector<double> stiffness_;
  MembraneLaw law_;
  double c1_, c2_;  // coefficients of the law
};

}  // namespace vacuform
