#include "worker/conductors/tail_crossings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double crossing_step_mm = 0.25;
constexpr double tolerance_on_part_mm = 0.15;  // of the samples, and of curves on the sheet

// The middle of a trace as points, with boxes around some of them each.
class TracePoints {
 public:
  explicit TracePoints(const Trace& trace) {
    const double length = trace.path().length();
    const int count = std::max(16, static_cast<int>(std::ceil(length * trace.scale() / crossing_step_mm)));
    for (int i = 0; i < count; ++i)
      if (const auto at = trace.at(length * i / count)) points_.push_back({length * i / count, *at});
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i % of_box == 0) boxes_.emplace_back();
      boxes_.back().extend(points_[i].place);
      whole_.extend(points_[i].place);
    }
  }

  struct Nearest {
    double mm = 0, along = 0;
  };
  // Nothing if that is farther than `within_mm`.
  std::optional<Nearest> nearest(const Vector3d& p, double within_mm) const {
    std::optional<Nearest> out;
    double least = within_mm * within_mm;
    if (whole_.squaredExteriorDistance(p) > least) return out;
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      if (boxes_[b].squaredExteriorDistance(p) > least) continue;
      for (std::size_t i = b * of_box; i < std::min(points_.size(), (b + 1) * of_box); ++i)
        if (const double d = (points_[i].place - p).squaredNorm(); d < least) {
          least = d;
          out = Nearest{std::sqrt(d), points_[i].along};
        }
    }
    return out;
  }

 private:
  static constexpr std::size_t of_box = 16;
  struct OnTrace {
    double along;
    Vector3d place;
  };
  std::vector<OnTrace> points_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  Eigen::AlignedBox3d whole_;
};

// One passage of the tail over or close to a trace: of the tail where its leads must be cut and where the patch lies below it,
// and of the trace what the leads cover.
struct Passage {
  TailCrossing crossing;
  Interval cut, patched;
};

void widen_to(Interval& part, double x) {
  part.from = std::min(part.from, x);
  part.to = std::max(part.to, x);
}

// The points across the tail that decide: the edges of both leads.
std::vector<Vector3d> edges_at(const PartLine& line, const PartLine::Point& point, const LeadSizes& sizes) {
  std::vector<Vector3d> out{point.place};
  for (const double left :
       {-sizes.pair_mm() / 2, -sizes.between_mm / 2, sizes.between_mm / 2, sizes.pair_mm() / 2})
    if (const auto at = line.beside(point, left)) out.push_back(line.surface().place(*at));
  return out;
}

std::vector<Passage> passages(const PartLine& line, const LeadSizes& sizes, const OtherTrace& other,
                              const CoilSettings& settings) {
  const TracePoints trace(*other.trace);
  const double length = other.trace->path().length();
  const double cut_mm = other.width_mm / 2 + settings.clearance_mm + tolerance_on_part_mm,
               patch_mm = other.width_mm / 2 + settings.patch_margin_mm + tolerance_on_part_mm,
               most = std::max(cut_mm, patch_mm);
  std::vector<Passage> out;
  bool in = false;
  for (const PartLine::Point& point : line.points()) {
    bool near = false;
    if (trace.nearest(point.place, most + sizes.pair_mm() / 2 + 0.5))
      for (const Vector3d& p : edges_at(line, point, sizes)) {
        const auto found = trace.nearest(p, most);
        if (!found) continue;
        if (!in && !near) {
          TailCrossing crossing{.under = other.element, .patch = {found->along, found->along}};
          crossing.patch_width_mm = other.width_mm + 2 * settings.patch_margin_mm;
          const Interval here{point.along, point.along};
          out.push_back({std::move(crossing), here, here});
        }
        near = true;
        Passage& passage = out.back();
        // The loop may go round between them.
        const double first = passage.crossing.patch.middle(),
                     along = found->along - length * std::round((found->along - first) / length);
        widen_to(passage.crossing.patch, along);
        if (found->mm < cut_mm) widen_to(passage.cut, point.along);
        if (found->mm < patch_mm) widen_to(passage.patched, point.along);
      }
    in = near;
  }
  return out;
}

}  // namespace

std::optional<CrossedTraces> crossed_traces(const PartLine& line, const LeadSizes& sizes,
                                            const std::vector<OtherTrace>& others,
                                            const CoilSettings& settings) {
  std::vector<Passage> all;
  for (const OtherTrace& other : others)
    for (Passage& passage : passages(line, sizes, other, settings)) {
      const double margin = (settings.patch_margin_mm + crossing_step_mm) / other.trace->scale();
      passage.crossing.patch.from -= margin;
      passage.crossing.patch.to += margin;
      passage.crossing.place = line.at(passage.cut.middle()).place;
      all.push_back(std::move(passage));
    }
  std::sort(all.begin(), all.end(), [](const Passage& a, const Passage& b) {
    return std::pair(a.cut.from, a.crossing.under) < std::pair(b.cut.from, b.crossing.under);
  });
  CrossedTraces out;
  for (Passage& passage : all) {
    const double step = crossing_step_mm, overlap = settings.bridge_overlap_mm;
    TailBridge bridge{{passage.cut.from - step, passage.cut.to + step},
                      {std::min(passage.cut.from, passage.patched.from) - step - overlap,
                       std::max(passage.cut.to, passage.patched.to) + step + overlap}};
    out.crossings.push_back(std::move(passage.crossing));
    if (!out.bridges.empty() && bridge.reach.from < out.bridges.back().reach.to + settings.clearance_mm) {
      for (const double x : {bridge.cut.from, bridge.cut.to}) widen_to(out.bridges.back().cut, x);
      for (const double x : {bridge.reach.from, bridge.reach.to}) widen_to(out.bridges.back().reach, x);
    } else {
      out.bridges.push_back(bridge);
    }
  }
  if (!out.bridges.empty() &&
      (out.bridges.front().reach.from < 0 || out.bridges.back().reach.to > line.length()))
    return std::nullopt;
  return out;
}

}  // namespace vacuform
