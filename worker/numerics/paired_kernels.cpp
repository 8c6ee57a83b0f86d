#include "worker/numerics/paired_kernels.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "worker/numerics/avx2.hpp"

namespace vacuform {

namespace {

using Quad = PairedQuad;
using Row = PairedRow;

// The compiler lowers both to what the processor has, lane by lane.
using Lanes = float __attribute__((vector_size(16)));
using Eight = float __attribute__((vector_size(32)));
template <class Vector>
VACUFORM_INLINE void load(const Quad* from, Vector& out) {
  __builtin_memcpy(&out, from->data(), sizeof out);
}

// Subtracts the products of four columns with an entry of each from another column, from a row on.
template <class Vector>
VACUFORM_INLINE void subtract_products(const Vector& a, const Vector& b, const Vector& d, const Vector& e,
                                       const float (&by)[4], Quad* to) {
  Vector sum;
  load(to, sum);
  sum -= a * by[0] + b * by[1] + d * by[2] + e * by[3];
  __builtin_memcpy(to->data(), &sum, sizeof sum);
}
template <class Vector>
VACUFORM_INLINE void subtract_products(Quad* const (&from)[4], const float (&by)[4][4], Quad* const (&to)[4],
                                       int row) {
  Vector a, b, d, e;
  load(from[0] + row, a), load(from[1] + row, b), load(from[2] + row, d), load(from[3] + row, e);
  subtract_products(a, b, d, e, by[0], to[0] + row);
  subtract_products(a, b, d, e, by[1], to[1] + row);
  subtract_products(a, b, d, e, by[2], to[2] + row);
  subtract_products(a, b, d, e, by[3], to[3] + row);
}

// Cholesky's elimination of the first `own` columns (a multiple of four) of a symmetric matrix of 4 `quads` rows, of
// which the lower triangle counts. The inverse of the diagonal stands on the diagonal afterwards. `least`: of the pivots.
VACUFORM_INLINE bool eliminate_all(Quad* matrix, int quads, int own, const float* least) {
  const auto column = [&](int c) { return matrix + static_cast<std::ptrdiff_t>(c) * quads; };
  for (int c = 0; c < own; c += 4) {
    const int k = c / 4;
    float l[4][4];
    for (int j = 0; j < 4; ++j)
      for (int i = j; i < 4; ++i) l[i][j] = column(c + j)[k][i];
    float inverse[4];
    for (int j = 0; j < 4; ++j) {
      for (int m = 0; m < j; ++m)
        for (int i = j; i < 4; ++i) l[i][j] -= l[i][m] * l[j][m];
      const float pivot = std::max(l[j][j], c + j < own ? least[c + j] : 0.0f);
      if (!(pivot > 0) || !std::isfinite(l[j][j])) return false;
      inverse[j] = 1 / std::sqrt(pivot);
      for (int i = j + 1; i < 4; ++i) l[i][j] *= inverse[j];
    }
    for (int j = 0; j < 4; ++j) {
      column(c + j)[k][j] = inverse[j];
      for (int i = j + 1; i < 4; ++i) column(c + j)[k][i] = l[i][j];
    }
    Quad* const L[4] = {column(c), column(c + 1), column(c + 2), column(c + 3)};
    for (int r = k + 1; r < quads; ++r) {
      L[0][r] *= inverse[0];
      L[1][r] = (L[1][r] - L[0][r] * l[1][0]) * inverse[1];
      L[2][r] = (L[2][r] - L[0][r] * l[2][0] - L[1][r] * l[2][1]) * inverse[2];
      L[3][r] = (L[3][r] - L[0][r] * l[3][0] - L[1][r] * l[3][1] - L[2][r] * l[3][2]) * inverse[3];
    }
    for (int d = k + 1; d < quads; ++d) {  // four columns at a time
      float by[4][4];                      // of each of the four, the entries of the four before
      for (int j = 0; j < 4; ++j)
        for (int m = 0; m < 4; ++m) by[j][m] = L[m][d][j];
      Quad* const to[4] = {column(4 * d), column(4 * d + 1), column(4 * d + 2), column(4 * d + 3)};
      int r = d;
      for (; r + 1 < quads; r += 2) subtract_products<Eight>(L, by, to, r);
      if (r < quads) subtract_products<Lanes>(L, by, to, r);
    }
  }
  return true;
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] bool eliminate_all_avx2(Quad* matrix, int quads, int own, const float* least) {
  return eliminate_all(matrix, quads, own, least);
}
#endif

// The entries of two rows in four columns, times 65536, and those of one row. The first and the second two columns.
VACUFORM_INLINE void load(const Row* rows, Eight& first, Eight& second) {
  using Shorts = std::int16_t __attribute__((vector_size(32)));
  using Ints = std::int32_t __attribute__((vector_size(32)));
  static_assert(std::endian::native == std::endian::little);
  Shorts all;
  const Shorts none{};
  __builtin_memcpy(&all, rows, sizeof all);
  const Shorts low =
                   __builtin_shufflevector(none, all, 0, 16, 0, 17, 0, 18, 0, 19, 0, 24, 0, 25, 0, 26, 0, 27),
               high =
                   __builtin_shufflevector(none, all, 0, 20, 0, 21, 0, 22, 0, 23, 0, 28, 0, 29, 0, 30, 0, 31);
  first = __builtin_convertvector((Ints)low, Eight);
  second = __builtin_convertvector((Ints)high, Eight);
}
VACUFORM_INLINE void load(const Row* row, Lanes& first, Lanes& second) {
  using Shorts = std::int16_t __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
  Shorts all;
  const Shorts none{};
  __builtin_memcpy(&all, row, sizeof all);
  const Shorts low = __builtin_shufflevector(none, all, 0, 8, 0, 9, 0, 10, 0, 11),
               high = __builtin_shufflevector(none, all, 0, 12, 0, 13, 0, 14, 0, 15);
  first = __builtin_convertvector((Ints)low, Lanes);
  second = __builtin_convertvector((Ints)high, Lanes);
}
template <int which>
VACUFORM_INLINE void spread(const Eight& two, Eight& out) {
  out = __builtin_shufflevector(two, two, 2 * which, 2 * which, 2 * which, 2 * which + 1, 2 * which + 4,
                                2 * which + 4, 2 * which + 4, 2 * which + 5);
}
template <int which>
VACUFORM_INLINE void spread(const Lanes& two, Lanes& out) {
  out = __builtin_shufflevector(two, two, 2 * which, 2 * which, 2 * which, 2 * which + 1);
}
// Each of four columns: of one row, or of two.
template <class Vector>
struct Columns {
  Vector a, b, d, e;
};
template <class Vector>
VACUFORM_INLINE void load(const Row* row, Columns<Vector>& out) {
  Vector first, second;
  load(row, first, second);
  spread<0>(first, out.a), spread<1>(first, out.b), spread<0>(second, out.d), spread<1>(second, out.e);
}

// x -= the rows times y, of which the four columns are y[0] to y[3].
template <class Vector>
VACUFORM_INLINE void subtract(const Row* row, const Columns<Vector>& y, Quad* x) {
  Columns<Vector> entry;
  load(row, entry);
  Vector value;
  load(x, value);
  value -= (y.a * entry.a + y.b * entry.b) + (y.d * entry.d + y.e * entry.e);
  __builtin_memcpy(x->data(), &value, sizeof value);
}
// sum += the transposed rows times x.
template <class Vector>
VACUFORM_INLINE void add(const Row* row, const Quad* x, Columns<Vector>& sum) {
  Columns<Vector> entry;
  load(row, entry);
  Vector value;
  load(x, value);
  sum.a += value * entry.a, sum.b += value * entry.b, sum.d += value * entry.d, sum.e += value * entry.e;
}
VACUFORM_INLINE void twice(const Lanes& one, Eight& out) {
  out = __builtin_shufflevector(one, one, 0, 1, 2, 3, 4, 5, 6, 7);
}
VACUFORM_INLINE void halves(const Eight& sum, Lanes& out) {
  out = __builtin_shufflevector(sum, sum, 0, 1, 2, 3) + __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
}

VACUFORM_INLINE void subtract_all(const Row* rows, int count, const Quad (&y)[4], Quad* x) {
  Columns<Lanes> one;
  load(y, one.a), load(y + 1, one.b), load(y + 2, one.d), load(y + 3, one.e);
  Columns<Eight> two;
  twice(one.a, two.a), twice(one.b, two.b), twice(one.d, two.d), twice(one.e, two.e);
  int r = 0;
  for (; r + 1 < count; r += 2) subtract(rows + r, two, x + r);
  if (r < count) subtract(rows + r, one, x + r);
}
VACUFORM_INLINE void add_all(const Row* rows, int count, const Quad* x, Quad (&sum)[4]) {
  Columns<Eight> two{};
  int r = 0;
  for (; r + 1 < count; r += 2) add(rows + r, x + r, two);
  Columns<Lanes> one;
  halves(two.a, one.a), halves(two.b, one.b), halves(two.d, one.d), halves(two.e, one.e);
  if (r < count) add(rows + r, x + r, one);
  __builtin_memcpy(sum[0].data(), &one.a, sizeof one.a),
      __builtin_memcpy(sum[1].data(), &one.b, sizeof one.b);
  __builtin_memcpy(sum[2].data(), &one.d, sizeof one.d),
      __builtin_memcpy(sum[3].data(), &one.e, sizeof one.e);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void subtract_all_avx2(const Row* rows, int count, const Quad (&y)[4], Quad* x) {
  subtract_all(rows, count, y, x);
}
[[gnu::target("avx2")]] void add_all_avx2(const Row* rows, int count, const Quad* x, Quad (&sum)[4]) {
  add_all(rows, count, x, sum);
}
#endif

}  // namespace

bool eliminate_columns([[maybe_unused]] bool avx2, Quad* matrix, int quads, int own, const float* least) {
#if defined(__x86_64__)
  if (avx2) return eliminate_all_avx2(matrix, quads, own, least);
#endif
  return eliminate_all(matrix, quads, own, least);
}

void subtract_rows([[maybe_unused]] bool avx2, const Row* rows, int count, const Quad (&y)[4], Quad* x) {
#if defined(__x86_64__)
  if (avx2) return subtract_all_avx2(rows, count, y, x);
#endif
  subtract_all(rows, count, y, x);
}
void add_rows([[maybe_unused]] bool avx2, const Row* rows, int count, const Quad* x, Quad (&sum)[4]) {
#if defined(__x86_64__)
  if (avx2) return add_all_avx2(rows, count, x, sum);
#endif
  add_all(rows, count, x, sum);
}

}  // namespace vacuform
