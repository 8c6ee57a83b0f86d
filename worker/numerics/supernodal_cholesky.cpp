#include "worker/numerics/supernodal_cholesky.hpp"

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

// The pattern in which every group is one unknown.
SymmetricMatrix groups_of(const SymmetricMatrix& pattern, int group) {
  SymmetricMatrix groups;
  groups.size = pattern.size / group;
  groups.column_start.push_back(0);
  for (int c = 0; c < pattern.size; c += group) {
    for (int k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k)
      if (pattern.row[k] % group == 0) groups.row.push_back(pattern.row[k] / group);
    groups.column_start.push_back(static_cast<int>(groups.row.size()));
  }
  return groups;
}

}  // namespace

SupernodalCholesky::SupernodalCholesky(const SymmetricMatrix& pattern, int group) : size_(pattern.size) {
  find_supernodes(pattern, group);
  find_slots(pattern);
}

void SupernodalCholesky::find_supernodes(const SymmetricMatrix& pattern, int group) {
  const Analysis analysis(group == 1 ? pattern : groups_of(pattern, group));
  for (int k = 0; k < size_; ++k) order_.push_back(group * analysis.order()[k / group] + k % group);
  owner_.resize(order_.size());
  std::size_t values = 0;
  for (int s = 0; s < analysis.supernodes(); ++s) {
    Supernode node;
    node.first = group * analysis.first_column()[s];
    node.columns = group * analysis.first_column()[s + 1] - node.first;
    node.rows = group * (analysis.first_row()[s + 1] - analysis.first_row()[s]);
    node.index = rows_.size();
    node.value = values;
    for (int i = analysis.first_row()[s]; i < analysis.first_row()[s + 1]; ++i)
      for (int d = 0; d < group; ++d) rows_.push_back(group * analysis.rows()[i] + d);
    values += static_cast<std::size_t>(node.rows) * static_cast<std::size_t>(node.columns);
    std::fill_n(owner_.begin() + node.first, node.columns, s);
    supernodes_.push_back(node);
  }
  factor_.resize(values);

  in_parent_.assign(rows_.size(), 0);
  for (Supernode& node : supernodes_) {
    if (node.rows == node.columns) continue;
    node.parent = owner_[rows_[node.index + static_cast<std::size_t>(node.columns)]];
    // Both lists ascend: one walk finds all.
    int place = 0;
    for (int i = node.columns; i < node.rows; ++i) {
      const std::size_t k = node.index + static_cast<std::size_t>(i);
      while (rows_[supernodes_[node.parent].index + static_cast<std::size_t>(place)] != rows_[k]) ++place;
      in_parent_[k] = place;
    }
  }
}

void SupernodalCholesky::find_slots(const SymmetricMatrix& pattern) {
  std::vector<int> place(order_.size());
  for (int k = 0; k < size_; ++k) place[order_[k]] = k;
  slot_.reserve(pattern.row.size());
  for (int c = 0; c < size_; ++c)
    for (int k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k) {
      const auto [column, row] = std::minmax(place[c], place[pattern.row[k]]);
      const Supernode& node = supernodes_[owner_[column]];
      const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(node.index);
      const auto at = std::lower_bound(begin, begin + node.rows, row) - begin;
      slot_.push_back(node.value + static_cast<std::size_t>(column - node.first) * node.rows +
                      static_cast<std::size_t>(at));
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

template <int C>
void SupernodalCholesky::substitute(Columns<C>& B) const {
  Columns<C> x(B.rows(), C), part;
  for (int k = 0; k < size_; ++k) x.row(k) = B.row(order_[k]);
  for (const Supernode& node : supernodes_) {
    const ConstBlock block(factor_.data() + node.value, node.rows, node.columns);
    const int* rows = rows_.data() + node.index;
    part.setZero(node.rows, C);
    part.topRows(node.columns) = x.middleRows(node.first, node.columns);
    for (int j = 0; j < node.columns; ++j) {
      part.row(j) /= block(j, j);
      const Eigen::Matrix<double, 1, C> found = part.row(j);
      for (int i = j + 1; i < node.rows; ++i) part.row(i) -= block(i, j) * found;
    }
    x.middleRows(node.first, node.columns) = part.topRows(node.columns);
    for (int i = node.columns; i < node.rows; ++i) x.row(rows[i]) += part.row(i);
  }
  for (auto node = supernodes_.rbegin(); node != supernodes_.rend(); ++node) {
    const ConstBlock block(factor_.data() + node->value, node->rows, node->columns);
    const int* rows = rows_.data() + node->index;
    part.resize(node->rows, C);
    for (int i = 0; i < node->rows; ++i) part.row(i) = x.row(rows[i]);
    for (int j = node->columns - 1; j >= 0; --j) {
      const int below = node->rows - j - 1;
      part.row(j) -= block.col(j).tail(below).transpose() * part.bottomRows(below);
      part.row(j) /= block(j, j);
    }
    x.middleRows(node->first, node->columns) = part.topRows(node->columns);
  }
  for (int k = 0; k < size_; ++k) B.row(order_[k]) = x.row(k);
}

void SupernodalCholesky::solve(Columns<1>& B) const { substitute<1>(B); }
void SupernodalCholesky::solve(Columns<2>& B) const { substitute<2>(B); }

}  // namespace vacuform
