// The inner loops of PairedCholesky. With or without AVX2 they give the same bytes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace vacuform {

// Three columns for the first matrix, one for the second; or four entries of one column.
using PairedQuad = Eigen::Array4f;
// A row of the factors: the entries in four columns of both matrices in turn, in units of each column. 15 bits do for a
// preconditioner, and a solve takes as long as the factors are large.
using PairedRow = std::array<std::int16_t, 8>;

// Cholesky's elimination of the first `own` columns (a multiple of four) of a symmetric matrix of 4 `quads` rows, of
// which the lower triangle counts. The inverse of the diagonal stands on the diagonal afterwards. `least`: of the pivots.
// False when a pivot is not positive.
bool eliminate_columns(bool avx2, PairedQuad* matrix, int quads, int own, const float* least);

// x -= the rows times y, of which the four columns are y[0] to y[3]. The entries of the rows count 65536 times.
void subtract_rows(bool avx2, const PairedRow* rows, int count, const PairedQuad (&y)[4], PairedQuad* x);
// sum = the transposed rows times x.
void add_rows(bool avx2, const PairedRow* rows, int count, const PairedQuad* x, PairedQuad (&sum)[4]);

}  // namespace vacuform
