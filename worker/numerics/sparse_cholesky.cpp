#include "worker/numerics/sparse_cholesky.hpp"

#include <suitesparse/cholmod.h>

#include <cstring>
#include <stdexcept>

namespace vacuform {

struct SparseCholesky::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;  // kept between solves

  State() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal =
        CHOLMOD_SIMPLICIAL;  // a scalar grid has supernodes too small to pay, and no BLAS threads
    common.final_ll = 0;
    common.quick_return_if_not_posdef = 1;
  }
  ~State() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_finish(&common);
  }
};

namespace {
cholmod_sparse view(const SymmetricMatrix& matrix) {
  cholmod_sparse a{};
  a.nrow = a.ncol = static_cast<std::size_t>(matrix.size);
  a.nzmax = matrix.row.size();
  a.p = const_cast<int*>(matrix.column_start.data());
  a.i = const_cast<int*>(matrix.row.data());
  a.x = const_cast<double*>(matrix.value.data());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}
}  // namespace

SparseCholesky::SparseCholesky() : state_(std::make_unique<State>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SymmetricMatrix& matrix, const std::vector<int>& order) {
  auto a = view(matrix);
  auto& common = state_->common;
  cholmod_free_factor(&state_->factor, &common);
  common.nmethods = 1;
  common.method[0].ordering = order.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
  common.postorder = order.empty();
  state_->factor = order.empty() ? cholmod_analyze(&a, &common)
                                 : cholmod_analyze_p(&a, const_cast<int*>(order.data()), nullptr, 0, &common);
  if (!state_->factor) throw std::runtime_error("CHOLMOD cannot analyse the matrix");
}

bool SparseCholesky::factor(const SymmetricMatrix& matrix) {
  auto a = view(matrix);
  auto& common = state_->common;
  if (!cholmod_factorize(&a, state_->factor, &common))
    throw std::runtime_error("CHOLMOD cannot factor the matrix");
  if (common.status == CHOLMOD_NOT_POSDEF || state_->factor->minor != state_->factor->n) return false;
  // A simplicial LDL' also "factors" an indefinite matrix; its diagonal tells.
  const auto* f = state_->factor;
  if (!f->is_super && !f->is_ll) {
    const auto* p = static_cast<const int*>(f->p);
    const auto* x = static_cast<const double*>(f->x);
    for (std::size_t k = 0; k < f->n; ++k)
      if (!(x[p[k]] > 0)) return false;
  }
  return true;
}

SparseCholesky::Factors SparseCholesky::factors() const {
  const auto* f = state_->factor;
  return {static_cast<const int*>(f->p), static_cast<const int*>(f->nz), static_cast<const int*>(f->i),
          static_cast<const double*>(f->x)};
}

void SparseCholesky::solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) {
  cholmod_dense b{};
  b.nrow = b.d = static_cast<std::size_t>(B.rows());
  b.ncol = static_cast<std::size_t>(B.cols());
  b.nzmax = b.nrow * b.ncol;
  b.x = const_cast<double*>(B.data());
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_solve2(CHOLMOD_A, state_->factor, &b, nullptr, &state_->x, nullptr, &state_->y, &state_->e,
                      &state_->common))
    throw std::runtime_error("CHOLMOD cannot solve");
  X.resize(B.rows(), B.cols());
  std::memcpy(X.data(), state_->x->x, sizeof(double) * b.nzmax);
}

}  // namespace vacuform
