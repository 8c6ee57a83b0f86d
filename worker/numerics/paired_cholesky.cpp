#include "worker/numerics/paired_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Quad = PairedCholesky::Quad;
using Row = PairedRow;

constexpr int worth_a_thread = 2500;  // rows
constexpr float most_units = 32767;

// Entries of both matrices in turn (t0, n0, t1, n1): one of the two for the three columns and the one.
template <int which>
Quad spread(const Quad& two) {
  return {two[2 * which], two[2 * which], two[2 * which], two[2 * which + 1]};
}

int fours(int n) { return (n + 3) / 4; }

}  // namespace

void PairedCholesky::analyse(const Dissection& dissection, std::span<const std::array<int, 3>> triangles) {
  const int rows = dissection.parts.empty() ? 0 : dissection.parts.back().end;
  triangles_.assign(triangles.begin(), triangles.end());
  fronts_.clear();
  border_row_.clear();
  std::vector<int> front_of_row(static_cast<std::size_t>(rows));
  for (const auto& part : dissection.parts) {
    const int own = part.end - part.begin;
    std::fill_n(front_of_row.begin() + part.begin, own, static_cast<int>(fronts_.size()));
    fronts_.push_back({.first_row = part.begin,
                       .own = own,
                       .padded = 4 * fours(own),
                       .first = part.first,
                       .second = part.second});
  }

  // A triangle belongs to the front that eliminates its first corner.
  std::vector<int> owner;
  std::vector<int> count(fronts_.size() + 1, 0);
  for (const auto& t : triangles) {
    int first = -1;
    for (const int row : t)
      if (row >= 0 && (first < 0 || row < first)) first = row;
    owner.push_back(first < 0 ? -1 : front_of_row[first]);
    if (first >= 0) ++count[owner.back() + 1];
  }
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    fronts_[f].triangles_begin = fronts_[f].triangles_end = count[f];
    count[f + 1] += count[f];
  }
  triangle_.resize(static_cast<std::size_t>(count.back()));
  for (std::size_t k = 0; k < owner.size(); ++k)
    if (owner[k] >= 0) triangle_[fronts_[owner[k]].triangles_end++] = static_cast<int>(k);

  place_.resize(triangle_.size());
  place_in_parent_.clear();
  std::vector<int> place(static_cast<std::size_t>(rows), -1), border;
  std::size_t blocks = 0, values = 0, work = 0;
  for (Front& front : fronts_) {
    const int end = front.first_row + front.own;
    border.clear();
    const auto meet = [&](int row) {
      if (row < end || place[row] >= 0) return;
      place[row] = 0;
      border.push_back(row);
    };
    for (int k = front.triangles_begin; k < front.triangles_end; ++k)
      for (const int row : triangles[triangle_[k]]) meet(row);
    front.weight = front.own;
    for (const int child : {front.first, front.second}) {
      if (child < 0) continue;
      const Front& c = fronts_[child];
      front.weight += c.weight;
      for (int k = 0; k < c.border; ++k) {
        const int row = border_row_[c.border_begin + k];
        if (row < front.first_row)
          throw std::logic_error("the parts of a dissection are joined beside those that separate them");
        meet(row);
      }
    }
    std::sort(border.begin(), border.end());
    front.border = static_cast<int>(border.size());
    front.border_begin = border_row_.size();
    border_row_.insert(border_row_.end(), border.begin(), border.end());
    place_in_parent_.resize(border_row_.size(), -1);

    for (int k = 0; k < front.own; ++k) place[front.first_row + k] = k;
    for (int k = 0; k < front.border; ++k) place[border[k]] = front.padded + k;
    for (int k = front.triangles_begin; k < front.triangles_end; ++k)
      for (int corner = 0; corner < 3; ++corner) {
        const int row = triangles[triangle_[k]][corner];
        place_[k][corner] = row < 0 ? -1 : place[row];
      }
    for (const int child : {front.first, front.second})
      if (child >= 0)
        for (int k = 0; k < fronts_[child].border; ++k)
          place_in_parent_[fronts_[child].border_begin + k] =
              place[border_row_[fronts_[child].border_begin + k]];
    for (const int row : border) place[row] = -1;

    front.block_begin = blocks;
    blocks += static_cast<std::size_t>(front.padded / 4);
    front.row_begin = values;
    for (int c = 4; c <= front.padded; c += 4) values += static_cast<std::size_t>(front.rows() - c);
    front.row_end = values;
    front.work_begin = work;
    work += static_cast<std::size_t>(front.rows());
  }
  blocks_.resize(blocks);
  rows_.resize(values);
  work_.resize(work);
}

bool PairedCholesky::factor(std::span<const Element> elements) {
  if (fronts_.empty()) return true;
  // In single precision a pivot can be lost in rounding, which is some 1e-7 of the diagonal.
  constexpr float of_diagonal = 2e-6f;
  const auto rows =
      static_cast<std::size_t>(fronts_.back().first_row) + static_cast<std::size_t>(fronts_.back().own);
  for (int m = 0; m < 2; ++m) {
    least_[m].assign(rows, 0);
    for (std::size_t k = 0; k < elements.size(); ++k)
      for (int corner = 0; corner < 3; ++corner)
        if (const int row = triangles_[k][corner]; row >= 0)
          least_[m][row] += of_diagonal * elements[k][m][(corner + 1) * (corner + 2) / 2 - 1];
  }
  Update none;
  return eliminate(static_cast<int>(fronts_.size()) - 1, elements, none);
}

void PairedCholesky::add_update(const Front& child, const std::vector<Quad>& update, Quad* matrix,
                                int quads) const {
  const int* to = place_in_parent_.data() + child.border_begin;
  const int height = fours(child.border);
  struct Run {
    int begin, end;
  };
  static thread_local std::vector<Run> runs;  // of rows that follow each other here and there
  runs.clear();
  for (int r = 0; r < child.border; ++r)
    if (r > 0 && to[r] == to[r - 1] + 1)
      runs.back().end = r + 1;
    else
      runs.push_back({r, r + 1});
  for (std::size_t first = 0; first < runs.size(); ++first)
    for (int c = runs[first].begin; c < runs[first].end; ++c) {
      const auto* from = reinterpret_cast<const float*>(update.data() + static_cast<std::size_t>(c) * height);
      auto* into = reinterpret_cast<float*>(matrix + static_cast<std::size_t>(to[c]) * quads);
      for (std::size_t k = first; k < runs.size(); ++k) {
        const int begin = std::max(c, runs[k].begin), offset = to[begin] - begin;
        for (int r = begin; r < runs[k].end; ++r) into[r + offset] += from[r];
      }
    }
}

void PairedCholesky::keep_columns(const Front& front, int which, const Quad* matrix, int quads) {
  Row* row = rows_.data() + front.row_begin;
  for (int c = 0; c < front.padded; c += 4) {
    const Quad* const column[4] = {
        matrix + static_cast<std::size_t>(c) * quads, matrix + static_cast<std::size_t>(c + 1) * quads,
        matrix + static_cast<std::size_t>(c + 2) * quads, matrix + static_cast<std::size_t>(c + 3) * quads};
    Block& block = blocks_[front.block_begin + static_cast<std::size_t>(c) / 4];
    int entry = 0;
    for (int j = 0; j < 4; ++j) {
      block.inverse[j / 2][2 * (j % 2) + which] = column[j][c / 4][j];
      for (int i = j + 1; i < 4; ++i, ++entry)
        block.below[entry / 2][2 * (entry % 2) + which] = column[j][c / 4][i];
    }
    float per_unit[4];
    for (int j = 0; j < 4; ++j) {  // rows beyond the last are zero
      Quad largest = Quad::Constant(std::numeric_limits<float>::min());
      for (int q = c / 4 + 1; q < quads; ++q) largest = largest.max(column[j][q].abs());
      block.unit[j / 2][2 * (j % 2) + which] = largest.maxCoeff() / most_units / 65536;
      per_unit[j] = most_units / largest.maxCoeff();
    }
    for (int q = c / 4 + 1; q < quads; ++q) {
      Eigen::Array4i units[4];
      for (int j = 0; j < 4; ++j) units[j] = (column[j][q] * per_unit[j]).cast<int>();
      const int rows = std::min(4, front.rows() - 4 * q);
      for (int i = 0; i < rows; ++i, ++row)
        for (int j = 0; j < 4; ++j) (*row)[2 * j + which] = static_cast<std::int16_t>(units[j][i]);
    }
  }
}

bool PairedCholesky::eliminate(int which, std::span<const Element> elements, Update& update) {
  const Front& front = fronts_[which];
  const int children[2] = {front.first, front.second};
  std::array<Update, 2> below;
  std::array<bool, 2> positive{true, true};
  const auto descend = [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      if (children[k] >= 0) positive[k] = eliminate(children[k], elements, below[k]);
  };
  if (front.weight >= worth_a_thread)
    in_parallel(0, 2, descend);
  else
    descend(0, 2);
  if (!positive[0] || !positive[1]) return false;

  const int quads = fours(front.rows());
  const auto eliminate_one = [&](int m) {
    static thread_local std::vector<Quad> dense;
    dense.assign(static_cast<std::size_t>(quads) * 4 * quads, Quad::Zero());
    const auto at = [&](int row, int column) -> float& {
      return dense[static_cast<std::size_t>(column) * quads + row / 4][row % 4];
    };
    for (int k = front.own; k < front.padded; ++k) at(k, k) = 1;
    for (int k = front.triangles_begin; k < front.triangles_end; ++k) {
      const auto& value = elements[triangle_[k]][m];
      int entry = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b <= a; ++b, ++entry) {
          const int p = place_[k][a], q = place_[k][b];
          if (p >= 0 && q >= 0) at(std::max(p, q), std::min(p, q)) += value[entry];
        }
    }
    for (int k = 0; k < 2; ++k) {
      if (children[k] >= 0) add_update(fronts_[children[k]], below[k][m], dense.data(), quads);
    }
    float* const least = least_[m].data() + front.first_row;
    if (!eliminate_columns(avx2_, dense.data(), quads, front.own, least)) {
      positive[m] = false;
      return;
    }

    keep_columns(front, m, dense.data(), quads);
    const int height = fours(front.border), skip = front.padded / 4;
    update[m].resize(static_cast<std::size_t>(height) * front.border);
    for (int c = 0; c < front.border; ++c)
      std::copy_n(dense.data() + static_cast<std::size_t>(front.padded + c) * quads + skip, height,
                  update[m].data() + static_cast<std::size_t>(c) * height);
  };
  if (front.weight >= worth_a_thread)
    in_parallel(0, 2, [&](int begin, int end) {
      for (int m = begin; m < end; ++m) eliminate_one(m);
    });
  else
    eliminate_one(0), eliminate_one(1);
  return positive[0] && positive[1];
}

void PairedCholesky::solve(std::span<Quad> columns) {
  if (fronts_.empty()) return;
  const int root = static_cast<int>(fronts_.size()) - 1;
  forward(root, columns);
  backward(root, columns);
}

void PairedCholesky::forward(int which, std::span<const Quad> columns) {
  const Front& front = fronts_[which];
  const int children[2] = {front.first, front.second};
  const auto descend = [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      if (children[k] >= 0) forward(children[k], columns);
  };
  if (front.weight >= worth_a_thread)
    in_parallel(0, 2, descend);
  else
    descend(0, 2);

  Quad* const w = work_.data() + front.work_begin;
  std::copy_n(columns.data() + front.first_row, front.own, w);
  std::fill_n(w + front.own, front.rows() - front.own, Quad::Zero());
  for (const int k : children) {
    if (k < 0) continue;
    const Front& child = fronts_[k];
    const Quad* from = work_.data() + child.work_begin + child.padded;
    const int* to = place_in_parent_.data() + child.border_begin;
    for (int r = 0; r < child.border; ++r) w[to[r]] += from[r];
  }
  const Block* block = blocks_.data() + front.block_begin;
  const Row* row = rows_.data() + front.row_begin;
  const int rows = front.rows();
  for (int c = 0; c < front.padded; c += 4, ++block) {
    Quad* const y = w + c;
    const auto& [inverse, l, unit] = *block;
    y[0] *= spread<0>(inverse[0]);
    y[1] = (y[1] - y[0] * spread<0>(l[0])) * spread<1>(inverse[0]);
    y[2] = (y[2] - y[0] * spread<1>(l[0]) - y[1] * spread<1>(l[1])) * spread<0>(inverse[1]);
    y[3] = (y[3] - y[0] * spread<0>(l[1]) - y[1] * spread<0>(l[2]) - y[2] * spread<1>(l[2])) *
           spread<1>(inverse[1]);
    const Quad in_units[4] = {y[0] * spread<0>(unit[0]), y[1] * spread<1>(unit[0]), y[2] * spread<0>(unit[1]),
                              y[3] * spread<1>(unit[1])};
    const int below = rows - c - 4;
    subtract_rows(avx2_, row, below, in_units, y + 4);
    row += below;
  }
}

void PairedCholesky::backward(int which, std::span<Quad> columns) {
  const Front& front = fronts_[which];
  Quad* const w = work_.data() + front.work_begin;
  const Row* row = rows_.data() + front.row_end;
  for (int c = front.padded - 4; c >= 0; c -= 4) {
    const auto& [inverse, l, unit] = blocks_[front.block_begin + static_cast<std::size_t>(c) / 4];
    const int below = front.rows() - c - 4;
    Quad* const x = w + c;
    row -= below;
    Quad sum[4];
    add_rows(avx2_, row, below, x + 4, sum);
    const auto& [a, b, d, e] = sum;
    x[3] = (x[3] - e * spread<1>(unit[1])) * spread<1>(inverse[1]);
    x[2] = (x[2] - d * spread<0>(unit[1]) - x[3] * spread<1>(l[2])) * spread<0>(inverse[1]);
    x[1] = (x[1] - b * spread<1>(unit[0]) - x[2] * spread<1>(l[1]) - x[3] * spread<0>(l[2])) *
           spread<1>(inverse[0]);
    x[0] = (x[0] - a * spread<0>(unit[0]) - x[1] * spread<0>(l[0]) - x[2] * spread<1>(l[0]) -
            x[3] * spread<0>(l[1])) *
           spread<0>(inverse[0]);
  }
  std::copy_n(w, front.own, columns.data() + front.first_row);
  const int children[2] = {front.second, front.first};  // down through the memory
  const auto descend = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      if (children[k] < 0) continue;
      const Front& child = fronts_[children[k]];
      Quad* const known = work_.data() + child.work_begin + child.padded;
      const int* from = place_in_parent_.data() + child.border_begin;
      for (int r = 0; r < child.border; ++r) known[r] = w[from[r]];
      backward(children[k], columns);
    }
  };
  if (front.weight >= worth_a_thread)
    in_parallel(0, 2, descend);
  else
    descend(0, 2);
}

}  // namespace vacuform
