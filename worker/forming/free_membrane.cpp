#include "worker/forming/free_membrane.hpp"

#include <algorithm>

#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

constexpr int parts = 8;
constexpr int worth_threads = 1000;  // fours

// One value for each of four triangles. The compiler lowers it to what the processor has, lane by lane, so the result
// does not depend on that.
using Lanes = double __attribute__((vector_size(32)));
using Mask = decltype(Lanes{} < Lanes{});

}  // namespace

void FreeMembrane::pack(const Membrane& membrane, const SheetGrid& grid, const std::vector<char>& held) {
  c1_ = membrane.c1(), c2_ = membrane.c2();
  vertices_.clear();
  std::vector<int> place(held.size(), -1);
  for (std::size_t v = 0; v < held.size(); ++v)
    if (!held[v]) {
      place[v] = static_cast<int>(vertices_.size());
      vertices_.push_back(static_cast<int>(v));
    }
  free_ = static_cast<int>(vertices_.size());
  std::vector<int> active;
  for (std::size_t k = 0; k < grid.triangles.size(); ++k) {
    const Triangle& t = grid.triangles[k];
    if (held[t[0]] && held[t[1]] && held[t[2]]) continue;
    active.push_back(static_cast<int>(k));
    for (const int v : t)
      if (place[v] < 0) {
        place[v] = static_cast<int>(vertices_.size());
        vertices_.push_back(v);
      }
  }

  const auto count = static_cast<long>(active.size());
  const auto first_of = [&](int part) { return static_cast<int>(count * part / parts); };
  parts_.resize(parts);
  int fours = 0;
  for (int k = 0; k < parts; ++k) {
    parts_[k].begin = fours;
    fours += (first_of(k + 1) - first_of(k) + 3) / 4;
    parts_[k].end = fours;
  }
  fours_.resize(static_cast<std::size_t>(fours));
  const auto fill = [&](int k) {
    Part& part = parts_[k];
    const int begin = first_of(k), end = first_of(k + 1);
    part.first = free_, part.last = 0;
    for (int i = begin; i < end; ++i)
      for (const int v : grid.triangles[active[i]])
        if (!held[v])
          part.first = std::min(part.first, place[v]), part.last = std::max(part.last, place[v] + 1);
    const int none = std::max(0, part.last - part.first);
    part.gradient.resize(static_cast<std::size_t>(none) + 1);
    for (int i = begin; i < end; i += 4) {
      Four& four = fours_[part.begin + (i - begin) / 4];
      for (int lane = 0; lane < 4; ++lane) {
        const bool present = i + lane < end;
        const int triangle = active[present ? i + lane : i];
        const Triangle& t = grid.triangles[triangle];
        const auto& g = membrane.shape_gradient(triangle);
        four.g01[lane] = g(0, 1), four.g02[lane] = g(0, 2), four.g11[lane] = g(1, 1),
        four.g12[lane] = g(1, 2);
        four.weight[lane] = present ? membrane.modulus(triangle) * membrane.rest_area(triangle) : 0;
        four.sixth[lane] = present ? 1.0 / 6 : 0;
        for (int c = 0; c < 3; ++c) {
          four.corner[c][lane] = place[t[c]];
          four.slot[c][lane] = held[t[c]] || !present ? none : place[t[c]] - part.first;
        }
      }
    }
  };
  in_parallel(0, parts, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) fill(k);
  });
}

double FreeMembrane::energy(const std::vector<Column>& x, double pressure, std::vector<Column>& gradient) {
  gradient.resize(static_cast<std::size_t>(free_));
  const auto evaluate = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Part& part = parts_[k];
      std::fill(part.gradient.begin(), part.gradient.end(), Column::Zero());
      part.energy = sum(part, x.data(), pressure, part.gradient.data());
    }
  };
  const auto gather = [&](int begin, int end) {
    std::fill(gradient.begin() + begin, gradient.begin() + end, Column::Zero());
    for (const Part& part : parts_)
      for (int v = std::max(begin, part.first); v < std::min(end, part.last); ++v)
        gradient[v] += part.gradient[v - part.first];
  };
  if (fours_.size() >= worth_threads) {
    in_parallel(0, parts, evaluate);
    in_parallel(0, free_, gather);
  } else {
    evaluate(0, parts);
    gather(0, free_);
  }
  double total = 0;
  for (const Part& part : parts_) total += part.energy;
  return total;
}

namespace {

struct Vector {
  Lanes x, y, z;
};

VACUFORM_INLINE void transpose(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, Vector& out) {
  const Lanes ab = __builtin_shufflevector(a, b, 0, 4, 2, 6), cd = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  out.x = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
  out.z = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  out.y = __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 5, 1, 5),
                                  __builtin_shufflevector(c, d, 1, 5, 1, 5), 0, 1, 4, 5);
}

VACUFORM_INLINE void load(const Column* from, const int (&at)[4], Vector& out) {
  Lanes row[4];
  for (int lane = 0; lane < 4; ++lane) __builtin_memcpy(&row[lane], from[at[lane]].data(), sizeof(Lanes));
  transpose(row[0], row[1], row[2], row[3], out);
}

VACUFORM_INLINE void add(Column* to, const int (&at)[4], const Vector& v) {
  const Lanes none{};
  const Lanes xy0 = __builtin_shufflevector(v.x, v.y, 0, 4, 2, 6),
              xy1 = __builtin_shufflevector(v.x, v.y, 1, 5, 3, 7);
  const Lanes z0 = __builtin_shufflevector(v.z, none, 0, 4, 2, 6),
              z1 = __builtin_shufflevector(v.z, none, 1, 5, 3, 7);
  const Lanes row[4] = {
      __builtin_shufflevector(xy0, z0, 0, 1, 4, 5), __builtin_shufflevector(xy1, z1, 0, 1, 4, 5),
      __builtin_shufflevector(xy0, z0, 2, 3, 6, 7), __builtin_shufflevector(xy1, z1, 2, 3, 6, 7)};
  for (int lane = 0; lane < 4; ++lane) {
    Lanes now;
    double* const place = to[at[lane]].data();
    __builtin_memcpy(&now, place, sizeof now);
    now += row[lane];
    __builtin_memcpy(place, &now, sizeof now);
  }
}

VACUFORM_INLINE void load(const double (&from)[4], Lanes& out) { __builtin_memcpy(&out, from, sizeof out); }
VACUFORM_INLINE void root(Lanes& v) {
  for (int lane = 0; lane < 4; ++lane) v[lane] = __builtin_sqrt(v[lane]);
}
VACUFORM_INLINE void cross(const Vector& a, const Vector& b, Vector& out) {
  out.x = a.y * b.z - a.z * b.y, out.y = a.z * b.x - a.x * b.z, out.z = a.x * b.y - a.y * b.x;
}

// The energy of four triangles, added to `energy` lane by lane.
template <class Four>
VACUFORM_INLINE void add_four(const Four& four, const Column* position, double pressure, double c1, double c2,
                              Lanes& energy, Column* gradient) {
  Vector a, e1, e2;
  load(position, four.corner[0], a), load(position, four.corner[1], e1), load(position, four.corner[2], e2);
  e1.x -= a.x, e1.y -= a.y, e1.z -= a.z;
  e2.x -= a.x, e2.y -= a.y, e2.z -= a.z;
  Lanes g01, g02, g11, g12, weight, push;
  load(four.g01, g01), load(four.g02, g02), load(four.g11, g11), load(four.g12, g12),
      load(four.weight, weight), load(four.sixth, push);
  push *= pressure;
  const Vector F1{g01 * e1.x + g02 * e2.x, g01 * e1.y + g02 * e2.y, g01 * e1.z + g02 * e2.z};
  const Vector F2{g11 * e1.x + g12 * e2.x, g11 * e1.y + g12 * e2.y, g11 * e1.z + g12 * e2.z};
  const Lanes c11 = F1.x * F1.x + F1.y * F1.y + F1.z * F1.z, c12 = F1.x * F2.x + F1.y * F2.y + F1.z * F2.z,
              c22 = F2.x * F2.x + F2.y * F2.y + F2.z * F2.z, trace = c11 + c22,
              J = c11 * c22 - c12 * c12;  // det C
  // The second Piola-Kirchhoff stress S = 2 dW/dC as (s11, s12, s22), by the invariants of C.
  const Lanes i = 1 / J, identity = 2 * (c1 + c2 * i), adjugate = 2 * (c2 - (c1 + c2 * trace) * i * i);
  Lanes W = c1 * (trace + i - 3) + c2 * (J + trace * i - 3);
  Lanes s11 = identity + adjugate * c22, s12 = -adjugate * c12, s22 = identity + adjugate * c11;
  // Tight both ways: l1 >= 1 and l1 l2^2 >= 1, without a root (l1^2 is the larger root of q^2 - trace q + J).
  const Mask tight =
      ((trace >= 2) | (1 - trace + J <= 0)) & (2 * J * J >= trace) & (J * J * J - trace * J + 1 >= 0);
  if (!(tight[0] & tight[1] & tight[2] & tight[3])) {
    // As Membrane: principal stretches, the relaxed density, and the stress by the spectral projectors of C.
    constexpr double e = Membrane::wrinkled_stiffness;
    const Lanes one = Lanes{} + 1, least = Lanes{} + 1e-6;
    const Lanes half = 0.5 * (c11 - c22);
    Lanes radius = half * half + c12 * c12;
    root(radius);
    Lanes l1 = 0.5 * trace + radius;
    root(l1);
    l1 = l1 > least ? l1 : least;
    Vector normal;
    cross(F1, F2, normal);
    Lanes l2 = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    root(l2);
    l2 /= l1;
    l2 = l2 > least ? l2 : least;
    const Lanes a2 = l1 * l1, b2 = l2 * l2, j = 1 / l1, ia2 = j * j, ib2 = 1 / b2, k = ia2 * ib2;
    const Lanes full = c1 * (a2 + b2 + k - 3) + c2 * (ia2 + ib2 + a2 * b2 - 3);
    const Lanes full_first = 2 * c1 * (l1 - k / l1) + 2 * c2 * (l1 * b2 - ia2 / l1);
    const Lanes full_second = 2 * c1 * (l2 - k / l2) + 2 * c2 * (l2 * a2 - ib2 / l2);
    const Mask pulled = l1 > one;
    const Lanes uniaxial_only = pulled ? c1 * (a2 + 2 * j - 3) + c2 * (2 * l1 + ia2 - 3) : Lanes{};
    const Lanes uniaxial_first = pulled ? 2 * c1 * (l1 - ia2) + 2 * c2 * (1 - ia2 * j) : Lanes{};
    const Lanes first = ((1 - e) * uniaxial_first + e * full_first) / l1, second = e * full_second / l2,
                gap = 2 * radius;
    const Mask round = gap < 1e-12 * a2;
    const Lanes slope = (first - second) / (round ? one : gap), shift = second - slope * b2;
    W = tight ? W : (1 - e) * uniaxial_only + e * full;
    s11 = tight ? s11 : round ? first : slope * c11 + shift;
    s12 = tight ? s12 : round ? Lanes{} : slope * c12;
    s22 = tight ? s22 : round ? first : slope * c22 + shift;
  }
  s11 *= weight, s12 *= weight, s22 *= weight;
  Vector normal;
  cross(e1, e2, normal);
  energy += weight * W + push * normal.z * (3 * a.z + e1.z + e2.z);
  Vector corner[3];
  const auto along = [&](const Lanes& f1, const Lanes& f2, const Lanes& n, Lanes& to0, Lanes& to1, Lanes& to2)
                         [[gnu::always_inline]] {
                           const Lanes p1 = s11 * f1 + s12 * f2, p2 = s12 * f1 + s22 * f2, pushed = push * n;
                           const Lanes second = g01 * p1 + g11 * p2, third = g02 * p1 + g12 * p2;
                           to0 = pushed - second - third, to1 = second + pushed, to2 = third + pushed;
                         };
  along(F1.x, F2.x, normal.x, corner[0].x, corner[1].x, corner[2].x);
  along(F1.y, F2.y, normal.y, corner[0].y, corner[1].y, corner[2].y);
  along(F1.z, F2.z, normal.z, corner[0].z, corner[1].z, corner[2].z);
  for (int c = 0; c < 3; ++c) add(gradient, four.slot[c], corner[c]);
}

template <class Four>
VACUFORM_INLINE double add_all(const Four* begin, const Four* end, const Column* x, double pressure,
                               double c1, double c2, Column* gradient) {
  Lanes energy{};
  for (const Four* four = begin; four != end; ++four) add_four(*four, x, pressure, c1, c2, energy, gradient);
  return (energy[0] + energy[1]) + (energy[2] + energy[3]);
}

#if defined(__x86_64__)
template <class Four>
[[gnu::target("avx2")]] double add_all_avx2(const Four* begin, const Four* end, const Column* x,
                                            double pressure, double c1, double c2, Column* gradient) {
  return add_all(begin, end, x, pressure, c1, c2, gradient);
}
#endif

}  // namespace

double FreeMembrane::sum(const Part& part, const Column* x, double pressure, Column* gradient) const {
  const Four *begin = fours_.data() + part.begin, *end = fours_.data() + part.end;
#if defined(__x86_64__)
  if (avx2_) return add_all_avx2(begin, end, x, pressure, c1_, c2_, gradient);
#endif
  return add_all(begin, end, x, pressure, c1_, c2_, gradient);
}

}  // namespace vacuform
