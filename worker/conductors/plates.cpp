#include "worker/conductors/plates.hpp"

#include <algorithm>
#include <cmath>

#include "worker/electrical/sheet_dielectric.hpp"

namespace vacuform {

namespace {

// The capacitance from the edge of a gap on, up to a length in the drawing.
struct Side {
  double between = 0, whole = 0, thickness = 0;
};

Side side_of(const Trace& near, const Trace& far, double from, double length, double width_mm,
             double permittivity) {
  Side out;
  constexpr double step_mm = 0.25;
  const int count = std::max(1, static_cast<int>(std::ceil(std::abs(length) * far.scale() / step_mm)));
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double a = from + length * i / count, b = from + length * (i + 1) / count, middle = (a + b) / 2;
    const auto here = near.at(middle), there = far.at(middle), begin = far.at(a), end = far.at(b);
    if (!here || !there || !begin || !end) continue;
    const double thickness = (*here - *there).norm(), mm = (*end - *begin).norm();
    if (!(thickness > 0)) continue;
    out.between += mm * plate_pf_per_mm(width_mm, thickness, permittivity);
    out.whole += mm * plate_pf_per_mm_with_edges(width_mm, thickness, permittivity);
    out.thickness += mm * thickness;
    sum += mm;
  }
  if (sum > 0) out.thickness /= sum;
  return out;
}

double in_series(double a, double b) { return a > 0 && b > 0 ? a * b / (a + b) : 0; }

}  // namespace

Patch opposite(const Patch& patch, const Patch& other_face) {
  const PlaneLocator locator(other_face.triangles, other_face.rest);
  Patch out = patch;
  for (std::size_t i = 0; i < patch.rest.size(); ++i)
    if (const auto at = locator.nearest(patch.rest[i], 5))
      out.inked[i] = interpolate(other_face.triangles, *at, other_face.inked);
  return out;
}

Plate plate_for(const Trace& near, const Trace& far, const Interval& gap, double width_mm,
                double permittivity, double wanted_pf, double room_before, double room_after) {
  const auto with = [&](double length) {
    Plate out{.before = std::min(length, room_before),
              .after = std::min(length, room_after),
              .wanted_pf = wanted_pf};
    const Side before = side_of(near, far, gap.from, -out.before, width_mm, permittivity),
               after = side_of(near, far, gap.to, out.after, width_mm, permittivity);
    out.pf = in_series(before.whole, after.whole);
    out.between_pf = in_series(before.between, after.between);
    out.thickness_mm = (before.thickness + after.thickness) / 2;
    return out;
  };
  double low = 0, high = std::max(room_before, room_after);
  Plate out = with(high);
  for (int i = 0; i < 40 && out.pf > wanted_pf * (1 + 1e-4); ++i) {
    const double middle = (low + high) / 2;
    const Plate tried = with(middle);
    (tried.pf < wanted_pf ? low : high) = middle;
    if (tried.pf >= wanted_pf) out = tried;
  }
  if (const auto rest = far.rest(gap.middle())) out.rest = *rest;
  return out;
}

}  // namespace vacuform
