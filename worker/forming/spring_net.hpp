// The sheet as a net of masses and springs, the model of the published predecessor: structural springs along the lines
// of the grid, shear springs along both diagonals of its cells, and bending springs from a vertex to the next but one.
//
// Units: mm, ms, g. Therefore N for forces, N/mm for stiffness, N/mm^2 for pressure.
//
// A structural or shear spring with the rest length L that represents the area A of sheet around it has the stiffness
// 3/4 E h A / L^2, with Young's modulus E and the sheet thickness h (the form is that of Van Gelder, "Approximate
// simulation of elastic membranes by triangulated spring meshes", J. Graphics Tools 1998). The factor makes a net of
// square cells isotropic at small strain, with the modulus E and Poisson's ratio 1/3. Central forces allow no other
// ratio (Cauchy), so the model cannot represent the 1/2 of an incompressible sheet.
//
// A bending spring pulls its middle vertex to the midpoint between its ends, with the bending stiffness E h^3 / 9 of an
// incompressible plate. A plain spring from end to end would not work: it resists bending only to second order, and a
// compressed sheet would buckle from one vertex to the next.
#pragma once

#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform {

struct Spring {
  int a, b;  // vertices
  int left = -1,
      right = -1;        // for an edge: the opposite vertices, seen from a towards b; otherwise -1
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

  // `stiffness` is a factor on Young's modulus for each triangle.
  SpringNet(const SheetGrid& grid, const std::vector<double>& stiffness, double thickness_mm,
            const Material& material);

  // The part that can move: first the vertices that are not held, in order, then the held ones that they connect to.
  SpringNet part(const std::vector<char>& held) const;

  int vertices() const { return static_cast<int>(mass_.size()); }
  int moving() const { return moving_; }                          // this many vertices come first
  const std::vector<int>& in_sheet() const { return in_sheet_; }  // per vertex: its number in the whole net
  const std::vector<double>& mass() const { return mass_; }       // g
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<BendingSpring>& bending_springs() const { return bending_springs_; }

  // Forces on the vertices at places x and velocities v (one column per vertex): of the springs and their dashpots, the
  // weight in a field of `gravity` mm/ms^2, and the pressure p A n / 3 of every triangle on its corners, against the
  // normal that points upwards. Correct for the moving vertices, and on a whole net for all.
  void forces(const Points& x, const Points& v, double p, double gravity, Points& f) const;

  // The Jacobians of these forces at x and zero velocity, as a matrix-free product. Symmetric, and exact for moving
  // vertices that are not on the edge of the sheet. With n along a spring of length L and r its rest length, df_a/dx_a
  // = -k [n n' + (1 - r/L)(I - n n')], df_a/dv_a = -k tau n n'. Where springs are compressed, or under pressure, the
  // matrix of a step can be indefinite.
  class Jacobian {
   public:
    Jacobian(const SpringNet& net, const Points& x, double p);
    // out = (by_place df/dx + by_velocity df/dv) d, on the moving vertices; d is zero on the held ones.
    void multiply(const Points& d, double by_place, double by_velocity, Points& out) const;
    // The diagonal blocks of that matrix, per moving vertex, with max(0, 1 - r/L) instead of 1 - r/L (Choi & Ko,
    // "Stable but responsive cloth", SIGGRAPH 2002): negative semi-definite for positive factors.
    std::vector<Eigen::Matrix3d> diagonal(double by_place, double by_velocity) const;
    // Upper bound of the angular frequencies of the net (Gershgorin), 1/ms.
    double highest_frequency() const;

   private:
    struct Link {
      Eigen::Vector3d along;  // unit vector
      double stiffness;       // along
      double across;          // stiffness across
    };
    // For the pressure: moving b by d changes the force on a by axis x d; moving a by d changes that on b by -axis x d.
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

  std::vector<Spring> springs_;  // those with a moving end, as for all members below
  std::vector<BendingSpring> bending_springs_;
  std::vector<Triangle> triangles_;
  std::vector<double> mass_;
  std::vector<int> in_sheet_;
  int moving_ = 0;
  double dashpot_ms_ = 0;  // tau: a dashpot pulls as its spring would if it were longer by tau times its rate
};

}  // namespace vacuform
