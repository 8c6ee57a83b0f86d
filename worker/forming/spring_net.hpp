// The sheet as a net of masses and springs, the model of the published predecessor: structural springs along the lines
// of the grid, shear springs along both diagonals of its cells, bending springs from a vertex over the next to the one
// after it.
//
// Units: mm, ms, g; hence N for forces, N/mm for stiffness, N/mm^2 for pressure.
//
// A structural or shear spring that is L long at rest and stands for the area A of sheet around it has the stiffness
// 3/4 E h A / L^2, with Young's modulus E and the sheet's thickness h (the form is that of Van Gelder, "Approximate
// simulation of elastic membranes by triangulated spring meshes", J. Graphics Tools 1998). The factor makes a net of
// square cells isotropic at small strain, with the modulus E and Poisson's ratio 1/3: central forces allow no other
// (Cauchy), so that the 1/2 of an incompressible sheet is out of the model's reach.
//
// A bending spring pulls its middle vertex to the middle between its ends, with the bending stiffness E h^3 / 9 of an
// incompressible plate. A plain spring from end to end would not do: it resists bending only in the second order, and
// a compressed sheet would buckle from one vertex to the next.
#pragma once

#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform {

struct Spring {
  int a, b;  // vertices
  int left = -1,
      right = -1;        // where the spring is an edge: the vertices opposite, seen from a towards b; or -1
  double rest = 0;       // length, mm
  double stiffness = 0;  // N/mm
};

struct BendingSpring {
  int a, middle, b;
  double stiffness;  // of the ends against the middle, N/mm
};

class SpringNet {
 public:
  struct Material {
    double young;    // N/mm^2
    double density;  // g/mm^3
  };

  // `stiffness` is, per triangle, a factor on Young's modulus.
  SpringNet(const SheetGrid& grid, const std::vector<double>& stiffness, double thickness_mm,
            const Material& material);

  // The part that can move: the vertices that are not held, in their order, then the held ones that they hang on.
  SpringNet part(const std::vector<char>& held) const;

  int vertices() const { return static_cast<int>(mass_.size()); }
  int moving() const { return moving_; }                          // the first so many vertices are not held
  const std::vector<int>& in_sheet() const { return in_sheet_; }  // per vertex: its number in the whole net
  const std::vector<double>& mass() const { return mass_; }       // g
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<BendingSpring>& bending_springs() const { return bending_springs_; }

  // Forces on the vertices at places x and velocities v (one column a vertex): those of the springs and of their
  // dashpots, the weight in a field of `gravity` mm/ms^2, and the pressure p A n / 3 of every triangle on its corners,
  // against the normal that it shows upwards. Right for the moving vertices, and on a whole net for all.
  void forces(const Points& x, const Points& v, double p, double gravity, Points& f) const;

  // The Jacobians of these forces at x and no velocity, as a product that needs no matrix. Symmetric, and exact for
  // moving vertices that are not on the sheet's edge. With n along a spring of length L and r its length at rest,
  // df_a/dx_a = -k [n n' + (1 - r/L)(I - n n')], df_a/dv_a = -k tau n n': where springs are compressed, or pressed,
  // the matrix of a step can be indefinite.
  class Jacobian {
   public:
    Jacobian(const SpringNet& net, const Points& x, double p);
    // out = (by_place df/dx + by_velocity df/dv) d, on the moving vertices; d is zero on the held ones.
    void multiply(const Points& d, double by_place, double by_velocity, Points& out) const;
    // The blocks on the diagonal of that matrix, per moving vertex, with max(0, 1 - r/L) instead of 1 - r/L (Choi &
    // Ko, "Stable but responsive cloth", SIGGRAPH 2002): negative semi-definite for positive factors.
    std::vector<Eigen::Matrix3d> diagonal(double by_place, double by_velocity) const;
    // No angular frequency of the net is higher (Gershgorin), 1/ms.
    double highest_frequency() const;

   private:
    struct Link {
      Eigen::Vector3d along;  // unit vector
      double stiffness;       // along
      double across;          // stiffness across
    };
    // Of the pressure: b moved by d turns the force on a by axis x d, a moved by d that on b by -axis x d.
    struct Turn {
      int a, b;
      Eigen::Vector3d axis;
    };
    const SpringNet& net_;
    std::vector<Link> links_;  // of springs()
    std::vector<Turn> turns_;
  };

 private:
  SpringNet() = default;

  std::vector<Spring> springs_;  // those with a moving end, as are all below
  std::vector<BendingSpring> bending_springs_;
  std::vector<Triangle> triangles_;
  std::vector<double> mass_;
  std::vector<int> in_sheet_;
  int moving_ = 0;
  double dashpot_ms_ = 0;  // tau: a dashpot pulls as its spring would if it were longer by tau times its rate
};

}  // namespace vacuform
