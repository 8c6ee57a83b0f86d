#include "worker/flattening/supernodal_cholesky.hpp"

#include <suitesparse/cholmod.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

namespace vacuform {

namespace {

using Block = Eigen::Map<Eigen::MatrixXd>;
using ConstBlock = Eigen::Map<const Eigen::MatrixXd>;

// CHOLMOD's symbolic supernodal factor of a pattern.
class Analysis {
 public:
  explicit Analysis(const SymmetricMatrix& pattern) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_AMD;
    common_.postorder = 1;
    cholmod_sparse a{};
    a.nrow = a.ncol = static_cast<std::size_t>(pattern.size);
    a.nzmax = pattern.row.size();
    a.p = const_cast<int*>(pattern.column_start.data());
    a.i = const_cast<int*>(pattern.row.data());
    a.stype = -1;
    a.itype = CHOLMOD_INT;
    a.xtype = CHOLMOD_PATTERN;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = a.packed = 1;
    factor_ = cholmod_analyze(&a, &common_);
    if (!factor_) cholmod_finish(&common_);
    if (!factor_) throw std::runtime_error("CHOLMOD cannot analyse the matrix");
  }
  ~Analysis() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  Analysis(const Analysis&) = delete;
  Analysis& operator=(const Analysis&) = delete;

  int supernodes() const { return static_cast<int>(factor_->nsuper); }
  const int* first_column() const { return static_cast<const int*>(factor_->super); }
  const int* first_row() const { return static_cast<const int*>(factor_->pi); }
  const int* rows() const { return static_cast<const int*>(factor_->s); }
  const int* order() const { return static_cast<const int*>(factor_->Perm); }

 private:
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

SupernodalCholesky::SupernodalCholesky(const SymmetricMatrix& pattern) : size_(pattern.size) {
  const Analysis analysis(pattern);
  order_.assign(analysis.order(), analysis.order() + size_);
  std::vector<int> place(order_.size()), owner(order_.size());
  for (int k = 0; k < size_; ++k) place[order_[k]] = k;

  std::size_t values = 0;
  for (int s = 0; s < analysis.supernodes(); ++s) {
    Supernode node;
    node.first = analysis.first_column()[s];
    node.columns = analysis.first_column()[s + 1] - node.first;
    node.rows = analysis.first_row()[s + 1] - analysis.first_row()[s];
    node.index = rows_.size();
    node.value = values;
    rows_.insert(rows_.end(), analysis.rows() + analysis.first_row()[s],
                 analysis.rows() + analysis.first_row()[s + 1]);
    values += static_cast<std::size_t>(node.rows) * static_cast<std::size_t>(node.columns);
    std::fill_n(owner.begin() + node.first, node.columns, s);
    supernodes_.push_back(node);
  }
  factor_.resize(values);

  const auto place_in = [&](const Supernode& node, int row) {
    const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(node.index);
    return static_cast<int>(std::lower_bound(begin, begin + node.rows, row) - begin);
  };
  in_parent_.assign(rows_.size(), 0);
  for (Supernode& node : supernodes_) {
    if (node.rows == node.columns) continue;
    node.parent = owner[rows_[node.index + static_cast<std::size_t>(node.columns)]];
    for (int i = node.columns; i < node.rows; ++i) {
      const std::size_t k = node.index + static_cast<std::size_t>(i);
      in_parent_[k] = place_in(supernodes_[node.parent], rows_[k]);
    }
  }

  slot_.reserve(pattern.row.size());
  for (int c = 0; c < size_; ++c)
    for (int k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k) {
      const auto [column, row] = std::minmax(place[c], place[pattern.row[k]]);
      const Supernode& node = supernodes_[owner[column]];
      slot_.push_back(node.value + static_cast<std::size_t>(column - node.first) * node.rows +
                      static_cast<std::size_t>(place_in(node, row)));
    }
}

bool SupernodalCholesky::factor(const SymmetricMatrix& matrix) {
  std::fill(factor_.begin(), factor_.end(), 0.0);
  for (std::size_t k = 0; k < slot_.size(); ++k) factor_[slot_[k]] += matrix.value[k];

  // What a supernode leaves for the rows below it waits on a stack until its parent, the next that needs it, comes.
  struct Waiting {
    int supernode;
    std::size_t at;
  };
  std::vector<Waiting> waiting;
  std::vector<double> stack;
  Eigen::MatrixXd below;
  for (int s = 0; s < static_cast<int>(supernodes_.size()); ++s) {
    const Supernode& node = supernodes_[s];
    const int own = node.columns, rest = node.rows - node.columns;
    Block block(factor_.data() + node.value, node.rows, own);
    below.setZero(rest, rest);
    while (!waiting.empty() && supernodes_[waiting.back().supernode].parent == s) {
      const Supernode& child = supernodes_[waiting.back().supernode];
      const int* to = in_parent_.data() + child.index + child.columns;
      const int count = child.rows - child.columns;
      const ConstBlock update(stack.data() + waiting.back().at, count, count);
      for (int j = 0; j < count; ++j) {
        double* column = to[j] < own ? &block(0, to[j]) : &below(0, to[j] - own) - own;
        for (int i = j; i < count; ++i) column[to[i]] += update(i, j);
      }
      stack.resize(waiting.back().at);
      waiting.pop_back();
    }
    auto top = block.topRows(own);
    Eigen::Ref<Eigen::MatrixXd> pivot(top);
    if (Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(pivot).info() != Eigen::Success) return false;
    if (rest == 0) continue;
    auto bottom = block.bottomRows(rest);
    top.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(bottom);
    below.selfadjointView<Eigen::Lower>().rankUpdate(bottom, -1);
    waiting.push_back({s, stack.size()});
    stack.insert(stack.end(), below.data(), below.data() + below.size());
  }
  return true;
}

void SupernodalCholesky::solve(Eigen::MatrixXd& B) const {
  Eigen::MatrixXd x(B.rows(), B.cols()), part;
  for (int k = 0; k < size_; ++k) x.row(k) = B.row(order_[k]);
  for (const Supernode& node : supernodes_) {
    const ConstBlock block(factor_.data() + node.value, node.rows, node.columns);
    const int* rows = rows_.data() + node.index;
    auto own = x.middleRows(node.first, node.columns);
    block.topRows(node.columns).triangularView<Eigen::Lower>().solveInPlace(own);
    part.noalias() = block.bottomRows(node.rows - node.columns) * own;
    for (int i = node.columns; i < node.rows; ++i) x.row(rows[i]) -= part.row(i - node.columns);
  }
  for (auto node = supernodes_.rbegin(); node != supernodes_.rend(); ++node) {
    const ConstBlock block(factor_.data() + node->value, node->rows, node->columns);
    const int* rows = rows_.data() + node->index;
    auto own = x.middleRows(node->first, node->columns);
    part.resize(node->rows - node->columns, x.cols());
    for (int i = node->columns; i < node->rows; ++i) part.row(i - node->columns) = x.row(rows[i]);
    own.noalias() -= block.bottomRows(node->rows - node->columns).transpose() * part;
    block.topRows(node->columns).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
  for (int k = 0; k < size_; ++k) B.row(order_[k]) = x.row(k);
}

}  // namespace vacuform
