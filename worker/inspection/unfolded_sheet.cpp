#include "worker/inspection/unfolded_sheet.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace vacuform {

using Eigen::Vector2d;

Unfolded unfolded(const Finished& job) {
  const std::size_t count = job.sheet.formed.size();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Unfolded out{std::vector<int>(count), std::vector<Vector2d>(count, Vector2d(nan, nan)),
               job.sheet.triangles};
  std::iota(out.vertex.begin(), out.vertex.end(), 0);
  std::vector<std::vector<int>> more(count);  // further copies of each vertex
  for (std::size_t i = 0; i < job.flattening.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      int& v = out.corners[static_cast<std::size_t>(job.flattening.triangles[i])][k];
      const auto first = static_cast<std::size_t>(v);
      const Vector2d& uv = job.print.pattern_uv[i][k];
      const auto is_it = [&](int copy) { return out.uv[static_cast<std::size_t>(copy)] == uv; };
      if (out.uv[first].hasNaN()) out.uv[first] = uv;
      if (is_it(v)) continue;
      auto copy = std::find_if(more[first].begin(), more[first].end(), is_it);
      if (copy == more[first].end()) {
        copy = more[first].insert(copy, static_cast<int>(out.vertex.size()));
        out.vertex.push_back(v);
        out.uv.push_back(uv);
      }
      v = *copy;
    }
  return out;
}

}  // namespace vacuform
