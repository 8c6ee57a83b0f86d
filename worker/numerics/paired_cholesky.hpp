// Cholesky factors of two symmetric positive definite matrices that are sums over the same triangles, in single
// precision, for preconditioning: both are solved at once, three columns with the first matrix and one with the second.
//
// Multifrontal (Duff, Reid 1983; Liu 1992) on a nested dissection (George 1973) that the caller knows. A general package
// spends most of its time on single entries, and on finding the pattern again whenever the unknowns change.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/numerics/avx2.hpp"
#include "worker/numerics/paired_kernels.hpp"

namespace vacuform {

// An order of elimination: each part follows its two subordinate parts, which only it and parts above it join.
struct Dissection {
  struct Part {
    int begin = 0, end = 0;       // in the order
    int first = -1, second = -1;  // subordinate parts, or -1
  };
  std::vector<Part> parts;  // subordinate ones first; the last is the whole
};

class PairedCholesky {
 public:
  using Quad = PairedQuad;
  // What a triangle adds to either matrix: entries 00, 10, 11, 20, 21, 22 of its corners.
  using Element = std::array<std::array<float, 6>, 2>;

  explicit PairedCholesky(bool use_avx2 = processor_has_avx2()) : avx2_(use_avx2) {}

  // The unknowns are the rows 0 to the last part's end - 1; a corner of a triangle is a row, or -1.
  void analyse(const Dissection& dissection, std::span<const std::array<int, 3>> triangles);
  // False when a matrix is not positive definite. One element a triangle. Deterministic at any number of threads, and on
  // any processor.
  bool factor(std::span<const Element> elements);
  // Solves in place; one entry a row. Deterministic at any number of threads.
  void solve(std::span<Quad> columns);

 private:
  // The dense matrix of a part: the part's own rows, filled up to whole fours, then the later rows that they meet.
  struct Front {
    int first_row = 0, own = 0, padded = 0;  // padded: own, rounded up to a multiple of 4
    int border = 0;                          // later rows
    int first = -1, second = -1;             // subordinate fronts
    int weight = 0;                          // rows of this and all subordinate fronts
    int triangles_begin = 0, triangles_end = 0;
    std::size_t border_begin = 0;            // in border_row_ and place_
    std::size_t block_begin = 0;             // in blocks_
    std::size_t row_begin = 0, row_end = 0;  // in rows_
    std::size_t work_begin = 0;              // in work_
    int rows() const { return padded + border; }
  };
  // Of each matrix: the lower triangle of a front's border after its own rows are eliminated, four rows an entry.
  using Update = std::array<std::vector<Quad>, 2>;

  // Adds what a subordinate front leaves to the matrix of the front above, of 4 `quads` rows.
  void add_update(const Front& child, const std::vector<Quad>& update, Quad* matrix, int quads) const;
  // Keeps the eliminated columns of a front's matrix for solving; which: of the two matrices.
  void keep_columns(const Front& front, int which, const Quad* matrix, int quads);
  bool eliminate(int front, std::span<const Element> elements, Update& update);
  void forward(int front, std::span<const Quad> columns);
  void backward(int front, std::span<Quad> columns);

  bool avx2_;
  std::vector<std::array<int, 3>> triangles_;
  std::array<std::vector<float>, 2> least_;  // pivot of each row
  std::vector<Front> fronts_;
  std::vector<int> triangle_;              // by front
  std::vector<std::array<int, 3>> place_;  // of the corners of these, in the front
  std::vector<int> border_row_;            // ascending in each front
  std::vector<int> place_in_parent_;       // parallel
  // Four columns of both factors: the inverse diagonal, the entries below it (10, 20, 30, 21, 31, 32), and the unit in which
  // the rows below the block are given; of both matrices in turn.
  struct Block {
    std::array<Quad, 2> inverse;
    std::array<Quad, 3> below;
    std::array<Quad, 2> unit;
  };
  std::vector<Block> blocks_;
  std::vector<PairedRow> rows_;  // by front and block
  std::vector<Quad> work_;
};

}  // namespace vacuform
