#include "worker/forming/preconditioner.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <stdexcept>

#include "worker/stage/parallel.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {
// The tangential value for three components, the normal one for the fourth.
Eigen::Array4f spread(const Eigen::Array2f& value) { return {value[0], value[0], value[0], value[1]}; }
}  // namespace

Preconditioner::Preconditioner(const Membrane& membrane, const SheetGrid& grid)
    : membrane_(membrane), grid_(grid), position_(grid.rest.size()) {
  for (std::size_t k = 0; k < grid.elimination_order.size(); ++k)
    position_[grid.elimination_order[k]] = static_cast<int>(k);
  const VertexFans fans(grid.triangles, grid.rest.size());
  neighbour_start_.push_back(0);
  for (int v = 0; v < static_cast<int>(grid.rest.size()); ++v) {
    std::vector<int> list(fans.around(v).begin(), fans.around(v).end());
    std::sort(list.begin(), list.end(), [&](int a, int b) { return position_[a] < position_[b]; });
    list.erase(std::unique(list.begin(), list.end()), list.end());
    neighbour_.insert(neighbour_.end(), list.begin(), list.end());
    neighbour_start_.push_back(static_cast<int>(neighbour_.size()));
  }
}

void Preconditioner::factor(const std::vector<char>& held, const Points& x) {
  vertex_.clear();
  row_of_vertex_.assign(held.size(), -1);
  for (std::size_t k = 0; k < grid_.elimination_order.size(); ++k) {
    if (static_cast<int>(k) == grid_.first_half) second_half_ = static_cast<int>(vertex_.size());
    if (static_cast<int>(k) == grid_.second_half) separator_ = static_cast<int>(vertex_.size());
    const int v = grid_.elimination_order[k];
    if (held[v]) continue;
    row_of_vertex_[v] = static_cast<int>(vertex_.size());
    vertex_.push_back(v);
  }
  const int n = static_cast<int>(vertex_.size());
  if (n == 0) return;

  // The pattern: each column begins with its diagonal.
  std::array<SymmetricMatrix, 2> matrix;
  SymmetricMatrix& pattern = matrix[0];
  pattern.size = n;
  pattern.column_start.push_back(0);
  for (int r = 0; r < n; ++r) {
    const int v = vertex_[r];
    pattern.row.push_back(r);
    for (int k = neighbour_start_[v]; k < neighbour_start_[v + 1]; ++k)
      if (row_of_vertex_[neighbour_[k]] > r) pattern.row.push_back(row_of_vertex_[neighbour_[k]]);
    pattern.column_start.push_back(static_cast<int>(pattern.row.size()));
  }
  pattern.value.assign(pattern.row.size(), 0);
  matrix[1] = pattern;

  std::array<SparseCholesky, 2> cholesky;
  std::array<bool, 2> positive{};
  const std::vector<int> natural = [&] {
    std::vector<int> order(static_cast<std::size_t>(n));
    for (int r = 0; r < n; ++r) order[r] = r;
    return order;
  }();
  in_parallel(0, 2, [&](int begin, int end) {
    for (int which = begin; which < end; ++which) {
      SymmetricMatrix& A = matrix[which];
      for (int k = 0; k < static_cast<int>(grid_.triangles.size()); ++k) {
        const Triangle& t = grid_.triangles[k];
        if (held[t[0]] && held[t[1]] && held[t[2]]) continue;
        const Eigen::Vector3d c = membrane_.rest_area(k) * (which == 0 ? membrane_.tangential_stiffness(x, k)
                                                                       : membrane_.normal_stiffness(x, k));
        Eigen::Matrix2d T;
        T << c[0], c[1], c[1], c[2];
        const auto& g = membrane_.shape_gradient(k);
        const Eigen::Matrix3d K = g.transpose() * T * g;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            const int column = row_of_vertex_[t[a]], row = row_of_vertex_[t[b]];
            if (column < 0 || row < column) continue;
            int at = A.column_start[column];
            while (A.row[at] != row) ++at;
            A.value[at] += K(a, b);
          }
      }
      cholesky[which].analyse(A, natural);
      positive[which] = cholesky[which].factor(A);
    }
  });
  if (!positive[0] || !positive[1])
    throw std::logic_error("the membrane's stand-in stiffness is not positive definite");

  const auto tangential = cholesky[0].factors(), normal = cholesky[1].factors();
  column_start_.assign(1, 0);
  row_.clear();
  value_.clear();
  inverse_diagonal_.clear();
  for (int c = 0; c < n; ++c) {
    const int first = tangential.column_start[c], second = normal.column_start[c];
    const float t = static_cast<float>(1 / tangential.value[first]),
                m = static_cast<float>(1 / normal.value[second]);
    inverse_diagonal_.emplace_back(t, t, t, m);
    for (int k = 1; k < tangential.count[c]; ++k) {
      row_.push_back(tangential.row[first + k]);
      value_.emplace_back(static_cast<float>(tangential.value[first + k]),
                          static_cast<float>(normal.value[second + k]));
    }
    column_start_.push_back(static_cast<int>(row_.size()));
  }
  rhs_.resize(static_cast<std::size_t>(n));
  first_carry_.resize(static_cast<std::size_t>(n - separator_));
  second_carry_ = first_carry_;
}

void Preconditioner::restrict_to(const std::vector<int>& vertices, const Points& x) {
  moving_.clear();
  for (int v : vertices) moving_.push_back(row_of_vertex_[v]);
  Points sum = Points::Zero(3, x.cols());
  for (const Triangle& t : grid_.triangles) {
    const Eigen::Vector3d a = x.col(t[0]), n = (x.col(t[1]) - a).cross(x.col(t[2]) - a);
    for (int v : t) sum.col(v) += n;
  }
  normal_.resize(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t k = 0; k < vertices.size(); ++k) normal_.col(k) = sum.col(vertices[k]).stableNormalized();
}

// The columns [begin, end) of L y = b. What they take from the separator's rows is carried apart.
void Preconditioner::eliminate(int begin, int end, std::vector<Quad>& separator) {
  for (int c = begin; c < end; ++c) {
    const Quad y = rhs_[c];
    int k = column_start_[c];
    for (; k < column_start_[c + 1] && row_[k] < separator_; ++k) rhs_[row_[k]] -= spread(value_[k]) * y;
    for (; k < column_start_[c + 1]; ++k) separator[row_[k] - separator_] -= spread(value_[k]) * y;
  }
}

// The columns [begin, end), from the last, of D L' x = y.
void Preconditioner::substitute(int begin, int end) {
  for (int c = end; c-- > begin;) {
    Quad x = rhs_[c] * inverse_diagonal_[c];
    for (int k = column_start_[c]; k < column_start_[c + 1]; ++k) x -= spread(value_[k]) * rhs_[row_[k]];
    rhs_[c] = x;
  }
}

void Preconditioner::apply(const Points& gradient, Points& direction) {
  std::fill(rhs_.begin(), rhs_.end(), Quad::Zero());
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const double along = normal_.col(k).dot(gradient.col(k));
    const Eigen::Vector3d across = gradient.col(k) - along * normal_.col(k);
    rhs_[moving_[k]] = Quad(static_cast<float>(across.x()), static_cast<float>(across.y()),
                            static_cast<float>(across.z()), static_cast<float>(along));
  }
  const int n = static_cast<int>(rhs_.size());
  const auto halves = [&](auto&& work) {
    constexpr int worth_threads = 4000;
    if (n < worth_threads)
      work(0, 2);
    else
      in_parallel(0, 2, work);
  };
  halves([&](int begin, int end) {
    for (int half = begin; half < end; ++half) {
      auto& carry = half == 0 ? first_carry_ : second_carry_;
      std::fill(carry.begin(), carry.end(), Quad::Zero());
      half == 0 ? eliminate(0, second_half_, carry) : eliminate(second_half_, separator_, carry);
    }
  });
  for (int c = separator_; c < n; ++c)
    rhs_[c] += first_carry_[c - separator_] + second_carry_[c - separator_];
  std::fill(first_carry_.begin(), first_carry_.end(), Quad::Zero());
  for (int c = separator_; c < n; ++c) {
    rhs_[c] += first_carry_[c - separator_];
    eliminate(c, c + 1, first_carry_);
  }
  substitute(separator_, n);
  halves([&](int begin, int end) {
    for (int half = begin; half < end; ++half)
      half == 0 ? substitute(0, second_half_) : substitute(second_half_, separator_);
  });

  direction.resize(3, gradient.cols());
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const Quad& q = rhs_[moving_[k]];
    const Eigen::Vector3d across(q[0], q[1], q[2]);
    direction.col(k) = across + (q[3] - normal_.col(k).dot(across)) * normal_.col(k);
  }
}

}  // namespace vacuform
