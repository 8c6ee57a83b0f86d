#include "worker/inspection/segments_json.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "worker/inspection/json_numbers.hpp"

namespace vacuform {

namespace {

double inked_mm2(const Patch& patch) {
  double sum = 0;
  for (const Triangle& t : patch.triangles) {
    const auto at = [&](std::size_t k) { return patch.inked[t[k]]; };
    sum += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
  }
  return sum;
}

}  // namespace

nlohmann::ordered_json segments_json(const Placement& placement, const Print& print) {
  using Json = nlohmann::ordered_json;
  Json segments = Json::array(), seams = Json::array();
  double worst = 1, gap = 0;
  for (const Segment& s : placement.charts) {
    segments.push_back({{"distortion", rounded(s.distortion)}, {"area_mm2", rounded(inked_mm2(s.patch), 1)}});
    worst = std::max(worst, s.distortion);
  }
  for (std::size_t i = 0; i < placement.seams.size(); ++i) {
    const Seam& seam = placement.seams[i];
    gap = std::max(gap, print.seam_gap_mm[i]);
    seams.push_back({{"segments", {seam.a + 1, seam.b + 1}},
                     {"length_mm", rounded(seam.length_mm, 2)},
                     {"mean_jump_mm", rounded(seam.mean_jump_mm, 3)},
                     {"max_jump_mm", rounded(seam.max_jump_mm, 3)},
                     {"gap_mm", rounded(print.seam_gap_mm[i], 6)},
                     {"place_mm", array(seam.place, 1)}});
  }
  return {{"count", placement.charts.size()},
          {"worst_distortion", rounded(worst)},
          {"largest_gap_mm", rounded(gap, 6)},
          {"segments", std::move(segments)},
          {"seams", std::move(seams)}};
}

}  // namespace vacuform
