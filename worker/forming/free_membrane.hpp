// The free part of a membrane: its vertices that are not held and the triangles around them, packed for the many
// evaluations of energy and gradient that one equilibrium takes. The same figures as Membrane::energy, up to rounding.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/forming/membrane.hpp"
#include "worker/forming/sheet_grid.hpp"
#include "worker/numerics/avx2.hpp"

namespace vacuform {

// x, y, z of a vertex or of a vector at it, and 0.
using Column = Eigen::Array4d;

class FreeMembrane {
 public:
  explicit FreeMembrane(bool use_avx2 = processor_has_avx2()) : avx2_(use_avx2) {}

  // Packs the membrane as it is now: call this again after the rest shape of triangles has changed.
  void pack(const Membrane& membrane, const SheetGrid& grid, const std::vector<char>& held);

  // The free vertices, ascending; then the held ones that they are joined to.
  int free() const { return free_; }
  const std::vector<int>& vertices() const { return vertices_; }

  // The energy of the triangles that have a free corner, and its gradient at the free vertices. `x`: of vertices().
  // Deterministic at any number of threads, and the same on processors with and without AVX2.
  double energy(const std::vector<Column>& x, double pressure, std::vector<Column>& gradient);

 private:
  // Four triangles, one a lane. A lane without a triangle has no weight.
  struct Four {
    double g01[4], g02[4], g11[4], g12[4];  // shape gradients of the second and third corners, 1/mm
    double weight[4];                       // modulus times rest area
    double sixth[4];                        // 1/6
    int corner[3][4];                       // in vertices()
    int slot[3][4];  // of the gradient, from the part's first vertex; the last is for held ones
  };
  // A run of triangles, and the free vertices between the first and the last that they meet.
  struct Part {
    int begin = 0, end = 0;  // in fours_
    int first = 0, last = 0;
    std::vector<Column> gradient;
    double energy = 0;
  };

  double sum(const Part& part, const Column* x, double pressure, Column* gradient) const;

  bool avx2_;
  std::vector<int> vertices_;
  int free_ = 0;
  std::vector<Four> fours_;
  std::vector<Part> parts_;
  double c1_ = 0, c2_ = 0;  // of the law
};

}  // namespace vacuform
