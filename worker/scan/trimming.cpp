#include "worker/scan/trimming.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "api/base/decimal.hpp"
#include "worker/scan/placing.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/upright.hpp"

namespace vacuform {
namespace {

// Shares of the radius of the smallest circle around the scan seen from above, so that a scan of twice the size is
// trimmed at twice the height: how far a part yields when it is lifted off grows with the radius.
constexpr double spacing_share = 1.0 / 250;  // 200,000 rays on a head
constexpr double depth_share = 1.0 / 70;     // shallower undercuts are noise, or yield
constexpr double area_share = 1.0 / 300;     // of the radius squared: smaller ones do not set the trim
constexpr double reported_depth_share =
    1.5 / 70;  // shallower ones lie within the grid of what the trim allows
constexpr double reported_area_share = 1.0 / 2500;  // smaller ones are one ray between two facets

constexpr double flat = 0.01;           // height over the radius from above: less is not a body
constexpr double least_kept = 0.05;     // of the height: less is refused
constexpr double usual_kept = 1.0 / 3;  // heads with face and neck keep two fifths
constexpr double wanted_kept = 0.4;     // another axis is proposed when it keeps this much

struct Limits {
  double spacing, depth, area, reported_depth, reported_area;
};
Limits limits_of(double radius) {
  const double square = radius * radius;
  return {spacing_share * radius, depth_share * radius, area_share * square, reported_depth_share * radius,
          reported_area_share * square};
}

struct OtherUp {
  UpAxis axis;
  double kept;  // share of the height
};

// The up axis that keeps most of the height, if that is enough to propose it and a mold can be cut there. The height is
// chosen on `judged`.
Result<std::optional<OtherUp>> better_up(const TriangleMesh& closed, const TriangleMesh& judged,
                                         const ScanSettings& settings, UpAxis used,
                                         const Eigen::Matrix3d& from_file, const CanCut& can_cut,
                                         const ScanProgress& progress) {
  struct Candidate {
    OtherUp up;
    TriangleMesh turned;
    double cut;
  };
  std::vector<Candidate> candidates;
  const auto caster = std::make_shared<RayCaster>(judged);
  for (const UpAxis axis :
       {UpAxis::plus_z, UpAxis::plus_y, UpAxis::minus_z, UpAxis::minus_y, UpAxis::plus_x, UpAxis::minus_x}) {
    if (axis == used) continue;
    const Eigen::Matrix3d turn = scan_turn(settings, axis) * from_file.transpose();
    TriangleMesh turned = closed;
    for (auto& p : turned.vertices) p = turn * p;
    const Box box = bounds(turned);
    const Limits limits = limits_of(enclosing_circle(turned).radius);
    VACUFORM_TRY(space, CoveredSpace::measure(judged, caster, turn, box.low.z(), limits.spacing, progress));
    const double cut = space.lowest_cut(limits.depth, limits.area) - box.low.z();
    const double kept = 1 - cut / box.size().z();
    if (kept < wanted_kept) continue;
    for (auto& p : turned.vertices) p.z() -= box.low.z();
    candidates.push_back({{axis, kept}, std::move(turned), cut});
  }
  std::ranges::stable_sort(candidates, std::ranges::greater(), [](const Candidate& c) { return c.up.kept; });
  for (const Candidate& candidate : candidates) {
    VACUFORM_CHECK(progress.tick());
    if (can_cut(candidate.turned, candidate.cut)) return std::optional(candidate.up);
  }
  return std::optional<OtherUp>();
}

// A trim near half of the height that leaves a mold, in whole millimetres if that is fine enough.
std::vector<Proposal> trim_proposals(const TriangleMesh& closed, double height, const CanCut& can_cut) {
  for (const double share : {0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8}) {
    const double step = height < 20 ? 0.1 : 1;
    const double trim = std::round(share * height / step) * step;
    if (can_cut(closed, trim))
      return {{{{"scan.trim_mm", trim}}, "keeps " + in_percent((height - trim) / height) + " of its height"}};
  }
  return {};
}

}  // namespace

Result<double> share_kept(const TriangleMesh& closed, const std::shared_ptr<const RayCaster>& caster,
                          const ScanSettings& settings, UpAxis up, const Eigen::Matrix3d& from_file,
                          const ScanProgress& progress) {
  const Eigen::Matrix3d turn = scan_turn(settings, up) * from_file.transpose();
  TriangleMesh turned = closed;
  for (auto& p : turned.vertices) p = turn * p;
  const Box box = bounds(turned);
  const Limits limits = limits_of(enclosing_circle(turned).radius);
  VACUFORM_TRY(space, CoveredSpace::measure(closed, caster, turn, box.low.z(), limits.spacing, progress));
  return (box.high.z() - space.lowest_cut(limits.depth, limits.area)) / (box.high.z() - box.low.z());
}

Result<Trim> choose_trim(const TriangleMesh& closed, const std::optional<TriangleMesh>& smooth,
                         const ScanSettings& settings, const ScanFindings& findings,
                         const Eigen::Matrix3d& from_file, const std::string& file_name,
                         const CanCut& can_cut, const ScanProgress& progress) {
  const double height = bounds(closed).high.z();
  if (settings.trim_mm && *settings.trim_mm > height - std::min(1.0, least_kept * height))
    return fail(Code::unusable_scan,
                "the scan is " + in_mm(height) + " high and trimming it at " + in_mm(*settings.trim_mm) +
                    " leaves nothing",
                "scan.trim_mm", "give a smaller height", trim_proposals(closed, height, can_cut));
  const double radius = enclosing_circle(closed).radius;
  if (height < flat * radius)
    return fail(Code::unusable_scan,
                "the scan is flat: only " + in_mm(height) + " would remain as a mold, " + in_mm(2 * radius) +
                    " across",
                file_name, "give a scan of a body, or turn it (scan.up)");
  const Limits limits = limits_of(radius);
  const TriangleMesh& judged = smooth ? *smooth : closed;
  VACUFORM_TRY(space, CoveredSpace::measure(judged, 0, limits.spacing, progress));
  Trim trim;
  trim.height_mm = settings.trim_mm ? *settings.trim_mm : space.lowest_cut(limits.depth, limits.area);
  const double kept = (height - trim.height_mm) / height;
  if (!settings.trim_mm && kept < usual_kept) {
    std::vector<Proposal> proposals;
    if (findings.holes_capped == 0) {  // else the opening tells which way is up
      VACUFORM_TRY(other, better_up(closed, judged, settings, findings.up, from_file, can_cut, progress));
      if (other)
        proposals.push_back(
            {{{"scan.up", name(other->axis)}}, "keeps " + in_percent(other->kept) + " of its height"});
    }
    for (Proposal& trim_there : trim_proposals(closed, height, can_cut)) proposals.push_back(trim_there);
    if (kept < least_kept)
      return fail(Code::unusable_scan,
                  "undercuts begin " + in_mm(trim.height_mm) + " above the scan's lowest point, and only " +
                      in_mm(height - trim.height_mm) + " of its " + in_mm(height) + " would remain as a mold",
                  file_name, "turn the scan (scan.up), or accept undercuts by giving the trim (scan.trim_mm)",
                  std::move(proposals));
    const auto below = space.undercuts(std::max(0.0, trim.height_mm - limits.spacing));
    const auto all = space.undercuts(0);
    Warning warning{"trim-discards",
                    "The automatic trim cuts " + in_mm(trim.height_mm) + " of the scan's " + in_mm(height) +
                        " off and keeps " + in_percent(kept) +
                        " of its height, because undercuts begin there" +
                        (all.empty() ? "" : "; the deepest reaches " + in_mm(all.front().depth_mm))};
    if (!below.empty()) {
      const auto& u = below.front();
      warning.marks.push_back({{u.place.x(), u.place.y(), 0}, u.depth_mm});
    }
    warning.figure = Warning::Figure{100 * (1 - kept), "%", 100 * (1 - usual_kept)};
    warning.proposals = std::move(proposals);
    trim.warning = std::move(warning);
  }
  if (smooth) {  // the sheet meets the noise too
    VACUFORM_TRY(rough, CoveredSpace::measure(closed, 0, limits.spacing, progress));
    space = std::move(rough);
  }
  for (Undercut u : space.undercuts(trim.height_mm)) {
    if (u.depth_mm <= limits.reported_depth || u.area_mm2 <= limits.reported_area) continue;
    u.place.z() = std::max(0.0, u.place.z() - trim.height_mm);
    trim.undercuts.push_back(u);
  }
  return trim;
}

}  // namespace vacuform
