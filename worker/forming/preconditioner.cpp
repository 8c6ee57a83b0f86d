#include "worker/forming/preconditioner.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <stdexcept>

#include "worker/stage/parallel.hpp"

namespace vacuform {

Preconditioner::Preconditioner(const Membrane& membrane, const SheetGrid& grid)
    : membrane_(membrane), grid_(grid), fans_(grid.triangles, grid.rest.size()) {}

void Preconditioner::factor(const std::vector<char>& held, const Points& x) {
  vertex_.clear();
  row_of_vertex_.assign(held.size(), -1);
  Dissection dissection = grid_.dissection;
  for (auto& part : dissection.parts) {
    const int begin = static_cast<int>(vertex_.size());
    for (int k = part.begin; k < part.end; ++k) {
      const int v = grid_.elimination_order[k];
      if (held[v]) continue;
      row_of_vertex_[v] = static_cast<int>(vertex_.size());
      vertex_.push_back(v);
    }
    part.begin = begin, part.end = static_cast<int>(vertex_.size());
  }
  if (vertex_.empty()) return;

  std::vector<std::array<int, 3>> triangles;
  std::vector<int> active;
  for (int k = 0; k < static_cast<int>(grid_.triangles.size()); ++k) {
    const Triangle& t = grid_.triangles[k];
    if (held[t[0]] && held[t[1]] && held[t[2]]) continue;
    active.push_back(k);
    triangles.push_back({row_of_vertex_[t[0]], row_of_vertex_[t[1]], row_of_vertex_[t[2]]});
  }
  elements_.resize(active.size());
  in_parallel(0, static_cast<int>(active.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const auto& g = membrane_.shape_gradient(active[k]);
      const auto stiffness = membrane_.stiffness(x, active[k]);
      for (int m = 0; m < 2; ++m) {
        const Eigen::Vector3d c = membrane_.rest_area(active[k]) * stiffness[m];
        Eigen::Matrix2d T;
        T << c[0], c[1], c[1], c[2];
        const Eigen::Matrix3d K = g.transpose() * T * g;
        elements_[k][m] = {float(K(0, 0)), float(K(1, 0)), float(K(1, 1)),
                           float(K(2, 0)), float(K(2, 1)), float(K(2, 2))};
      }
    }
  });
  cholesky_.analyse(dissection, triangles);
  if (!cholesky_.factor(elements_))
    throw std::logic_error("the membrane's stand-in stiffness is not positive definite");
  rhs_.resize(vertex_.size());
}

void Preconditioner::restrict_to(std::span<const int> vertices, const Points& x) {
  moving_.clear();
  for (int v : vertices) moving_.push_back(row_of_vertex_[v]);
  normal_.resize(vertices.size());
  in_parallel(0, static_cast<int>(vertices.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Eigen::Vector3d at = x.col(vertices[k]);
      const std::span<const int> around = fans_.around(vertices[k]);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t c = 0; c < around.size(); c += 2)
        sum += (x.col(around[c]) - at).cross(x.col(around[c + 1]) - at);
      normal_[k] << sum.stableNormalized().cast<float>(), 0;
    }
  });
}

void Preconditioner::apply(const std::vector<Column>& gradient, std::vector<Direction>& direction) {
  const int n = static_cast<int>(moving_.size());
  if (moving_.size() < rhs_.size()) std::fill(rhs_.begin(), rhs_.end(), PairedCholesky::Quad::Zero());
  in_parallel(0, n, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Direction g = gradient[k].cast<float>();
      const float along = (normal_[k] * g).sum();
      Direction split = g - along * normal_[k];
      split[3] = along;
      rhs_[moving_[k]] = split;
    }
  });
  cholesky_.solve(rhs_);
  direction.resize(moving_.size());
  in_parallel(0, n, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Direction across = rhs_[moving_[k]];
      const float along = across[3];
      across[3] = 0;
      direction[k] = across + (along - (normal_[k] * across).sum()) * normal_[k];
    }
  });
}

}  // namespace vacuform
