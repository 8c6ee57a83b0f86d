#include "worker/conductors/gap_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "api/base/decimal.hpp"
#include "worker/coils/inductance.hpp"
#include "worker/conductors/tail_sizes.hpp"
#include "worker/conductors/widened.hpp"
#include "worker/electrical/sheet_dielectric.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Vector3d> points_along(const Trace& trace, double from, double to) {
  constexpr double between_mm = 1;
  std::vector<Vector3d> out;
  const int count = std::max(1, static_cast<int>(std::ceil((to - from) * trace.scale() / between_mm)));
  for (int i = 0; i <= count; ++i)
    if (const auto at = trace.at(from + (to - from) * i / count)) out.push_back(*at);
  return out;
}

class Layout {
 public:
  Layout(const std::vector<LaidLoop>& loops, const std::vector<Vector3d>& border, const Settings& settings)
      : loops_(loops),
        border_(border),
        settings_(settings),
        pads_(pads_of(settings.coils)),
        plates_(prints_plates(settings.coils)),
        dielectric_(sheet_dielectric(settings.sheet)),
        near_(loops.size()),
        wanted_pf_(loops.size(), 0) {}

  GapLayout run(const std::optional<BodyBelow>& body) {
    if (plates_) find_wanted(body), add_neighbours();
    for (std::size_t i = 0; i < loops_.size(); ++i) add_gaps(i);
    if (lost_ > 0)
      out_.warnings.push_back(
          {.code = "gaps-left-out",
           .text = std::to_string(lost_) + " gaps have no room between the crossings of their loops",
           .figure = Warning::Figure{static_cast<double>(lost_), "gaps", 0.0}});
    if (plates_) add_plates();
    return std::move(out_);
  }

 private:
  int gaps_wanted(const Trace& trace) const {
    const CoilSettings& coils = settings_.coils;
    if (coils.gap_rule == GapRule::count) return coils.gaps;
    return gaps_for_frequency(trace.path().length() * trace.scale(), trace.width_mm(),
                              settings_.circuit.frequency_mhz);
  }

  // The place along a loop that is nearest to where its cable leaves.
  double towards_port(const Trace& trace) const {
    const bool edge = settings_.coils.port == PortSide::edge;
    constexpr int count = 180;
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      const double along = trace.path().length() * i / count;
      const auto at = trace.at(along);
      if (!at) continue;
      double far = edge ? std::numeric_limits<double>::infinity() : -at->z();
      if (edge)
        for (const Vector3d& p : border_) far = std::min(far, (p - *at).squaredNorm());
      if (far < least) least = far, best = along;
    }
    return best;
  }

  void add(const LaidLoop& loop, const Interval& along, bool port, bool drawn) {
    LoopGap& out = out_.gaps.emplace_back(LoopGap{.coil = loop.element,
                                                  .along = along,
                                                  .port = port,
                                                  .drawn = drawn,
                                                  .number = static_cast<int>(out_.gaps.size()) + 1});
    const Trace& trace = *loop.trace;
    const double at = along.middle();
    out.place = trace.at(at).value_or(Vector3d::Zero());
    const auto middle = trace.rest(at), left = trace.rest(at, 1);
    if (!middle || !left || !((*left - *middle).norm() > 0)) return;
    const double side = (*left - *middle).dot(loop.centre - *middle) < 0 ? -1 : 1;
    out.rest = *middle;
    out.inwards = side * (*left - *middle).normalized();
  }

  void add_gaps(std::size_t i) {
    const LaidLoop& loop = loops_[i];
    const LoopPath& path = loop.trace->path();
    if (std::vector<Interval> drawn = loop.drawn; !drawn.empty()) {
      const double port = towards_port(*loop.trace);
      const auto far = [&](const Interval& gap) { return apart_on_loop(gap.middle(), port, path.length()); };
      std::rotate(drawn.begin(),
                  std::min_element(drawn.begin(), drawn.end(),
                                   [&](const Interval& a, const Interval& b) { return far(a) < far(b); }),
                  drawn.end());
      for (const Interval& gap : drawn) add(loop, gap, &gap == &drawn.front(), true);
      return;
    }
    const int wanted = gaps_wanted(*loop.trace);
    if (wanted == 0) return;
    const double scale = loop.trace->scale(), ends = std::max(pads_.length, first_plate_mm(i, wanted)),
                 half = (pads_.gap / 2 + ends + settings_.coils.clearance_mm) / scale;
    std::vector<Interval> blocked = loop.covered;
    blocked.insert(blocked.end(), near_[i].begin(), near_[i].end());
    const std::vector<double> places =
        places_for_gaps(path.length(), wanted, {half, tail_room_mm(settings_.coils) / scale},
                        towards_port(*loop.trace), blocked);
    lost_ += wanted - static_cast<int>(places.size());
    for (const double at : places)
      add(loop, {at - pads_.gap / 2 / scale, at + pads_.gap / 2 / scale}, at == places.front(), false);
  }

  LoopOnPart on_part(const Trace& trace) const {
    const double length = trace.path().length();
    const std::vector<double> loads = trace_loads(trace, settings_.circuit.ink_stretch);
    LoopOnPart out;
    out.gaps = gaps_wanted(trace);
    out.loss_tangent = dielectric_.loss_tangent;
    out.line = points_along(trace, 0, length);
    if (out.line.size() < 4) return {};
    out.line.pop_back();  // where it began
    out.inductance_nh = self_inductance_nh(out.line, trace.width_mm());
    for (const double load : loads)
      out.squares += load * length * trace.scale() / static_cast<double>(loads.size()) / trace.width_mm();
    return out;
  }

  // What tunes and matches each loop, of all capacitors but that of the port in series.
  void find_wanted(const std::optional<BodyBelow>& body) {
    std::vector<LoopOnPart> on_parts;
    std::vector<std::size_t> of;
    for (std::size_t i = 0; i < loops_.size(); ++i)
      if (LoopOnPart loop = on_part(*loops_[i].trace); !loop.line.empty()) {
        on_parts.push_back(std::move(loop));
        of.push_back(i);
      }
    // Without a body only the coil's own losses count.
    const BodyBelow nothing{{{0, 0, 0}, 1e-3, 0}, 1e3};
    const ArrayCircuit circuit = array_circuit(on_parts, body.value_or(nothing), settings_.circuit);
    for (std::size_t k = 0; k < of.size(); ++k) wanted_pf_[of[k]] = circuit.loops[k].series_pf;
  }

  double half_plate_mm() const { return settings_.coils.plate_width_mm / 2 + plate_margin_mm; }

  // Where other loops come nearer to a trace than a plate on it may lie.
  void add_neighbours() {
    for (std::size_t other = 0; other < loops_.size(); ++other) {
      const Trace& trace = *loops_[other].trace;
      const std::vector<Vector3d> points = points_along(trace, 0, trace.path().length());
      keep_away(other, points, half_plate_mm() + trace.width_mm() / 2 + settings_.coils.clearance_mm);
    }
  }

  // No other plate lies nearer to the points of a loop than that.
  void keep_away(std::size_t from, const std::vector<Vector3d>& points, double reach_mm) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : points) box.extend(p);
    for (std::size_t i = 0; i < loops_.size(); ++i) {
      if (i == from) continue;
      const Trace& trace = *loops_[i].trace;
      const double length = trace.path().length();
      const int count = std::max(16, static_cast<int>(length * trace.scale()));
      const double step = length / count;
      for (int k = 0; k < count; ++k) {
        const auto at = trace.at(step * k);
        if (!at || box.exteriorDistance(*at) > reach_mm) continue;
        if (std::any_of(points.begin(), points.end(),
                        [&](const Vector3d& p) { return (p - *at).squaredNorm() < reach_mm * reach_mm; }))
          near_[i].push_back({step * (k - 0.5), step * (k + 0.5)});
      }
    }
  }

  // How long a plate is sought to be on each side of a gap when the gaps get their places: what it needs on half of the
  // sheet's thickness, or most of its share of the loop.
  double first_plate_mm(std::size_t i, int gaps) const {
    if (!plates_ || gaps < 2) return 0;
    const Trace& trace = *loops_[i].trace;
    const double share = trace.path().length() * trace.scale() / gaps;
    const double per_mm = plate_pf_per_mm_with_edges(
        settings_.coils.plate_width_mm, settings_.sheet.thickness_mm / 2, dielectric_.permittivity);
    return std::min(2 * wanted_pf_[i] * (gaps - 1) / per_mm, 0.2 * share);
  }

  std::size_t loop_of(const LoopGap& gap) const {
    const auto at = std::find_if(loops_.begin(), loops_.end(),
                                 [&](const LaidLoop& loop) { return loop.element == gap.coil; });
    return static_cast<std::size_t>(at - loops_.begin());
  }

  void add_plates() {
    int small = 0;
    double least = 1, wanted_mm2 = 0;
    Warning warning{.code = "plates-small", .text = {}};
    const double width = settings_.coils.plate_width_mm;
    for (LoopGap& gap : out_.gaps) {
      if (gap.port || gap.drawn) continue;
      const std::size_t i = loop_of(gap);
      const auto others = std::count_if(out_.gaps.begin(), out_.gaps.end(), [&](const LoopGap& each) {
        return each.coil == gap.coil && !each.port;
      });
      const Trace& trace = *loops_[i].trace;
      gap.plate = plate_for(trace, *loops_[i].far, gap.along, width, dielectric_.permittivity,
                            wanted_pf_[i] * static_cast<double>(others), room(i, gap, -1), room(i, gap, 1));
      keep_away(i, points_along(trace, gap.along.from - gap.plate->before, gap.along.to + gap.plate->after),
                2 * half_plate_mm() + settings_.coils.clearance_mm);
      if (gap.plate->pf >= 0.98 * gap.plate->wanted_pf) continue;
      ++small;
      if (const double share = gap.plate->pf / gap.plate->wanted_pf; share < least) {
        const double thickness =
            gap.plate->thickness_mm > 0 ? gap.plate->thickness_mm : settings_.sheet.thickness_mm;
        least = share;
        wanted_mm2 = 2 * gap.plate->wanted_pf * width /
                     plate_pf_per_mm_with_edges(width, thickness, dielectric_.permittivity);
      }
      if (warning.marks.size() < Warning::most_marks)
        warning.marks.push_back({{gap.place.x(), gap.place.y(), gap.place.z()}, width});
    }
    if (small == 0) return;
    warning.text = std::to_string(small) +
                   " printed capacitors have no room for what tunes their loops: the smallest has " +
                   decimal(100 * least, 0) + " % of it, and needs " + decimal(wanted_mm2, 0) +
                   " mm2 on each side of its gap";
    warning.figure = Warning::Figure{100 * least, "%", 98};
    out_.warnings.push_back(std::move(warning));
  }

  // From an edge of a gap to the next thing on its trace, mm in the drawing.
  double room(std::size_t i, const LoopGap& gap, int side) const {
    const Trace& trace = *loops_[i].trace;
    const LoopPath& path = trace.path();
    const double edge = side < 0 ? gap.along.from : gap.along.to,
                 clearance = settings_.coils.clearance_mm / trace.scale();
    const auto ahead = [&](double at) { return path.round(side < 0 ? edge - at : at - edge); };
    double out = path.length() / 4;
    for (const auto* parts : {&loops_[i].covered, &near_[i]})
      for (const Interval& part : *parts) out = std::min(out, ahead(side < 0 ? part.to : part.from));
    for (const LoopGap& other : out_.gaps) {
      if (&other == &gap || other.coil != gap.coil) continue;
      const double far = ahead(side < 0 ? other.along.to : other.along.from);
      // Two plates share what lies between them.
      out = std::min(out,
                     other.port || other.drawn ? far - pads_.length / trace.scale() : (far - clearance) / 2);
    }
    return std::max(0.0, out - plate_margin_mm / trace.scale() - clearance);
  }

  const std::vector<LaidLoop>& loops_;
  const std::vector<Vector3d>& border_;
  const Settings& settings_;
  const Pads pads_;
  const bool plates_;
  const Dielectric dielectric_;
  std::vector<std::vector<Interval>> near_;  // by loops: parts too near to others for a plate
  std::vector<double> wanted_pf_;            // by loops
  int lost_ = 0;
  GapLayout out_;
};

}  // namespace

Pads pads_of(const CoilSettings& settings) {
  switch (settings.capacitor) {
    case CapacitorCase::c0805:
    case CapacitorCase::printed:
      break;
    case CapacitorCase::c1111:
      return {1.8, 1.3, 3.0};
    case CapacitorCase::custom:
      return {settings.gap_mm, settings.pad_length_mm, settings.pad_width_mm};
  }
  return {0.9, 1.0, 1.45};
}

bool prints_plates(const CoilSettings& settings) {
  return settings.capacitor == CapacitorCase::printed &&
         (settings.gaps > 0 || settings.gap_rule != GapRule::count);
}

GapLayout lay_gaps(const std::vector<LaidLoop>& loops, const std::vector<Vector3d>& border,
                   const std::optional<BodyBelow>& body, const Settings& settings) {
  return Layout(loops, border, settings).run(body);
}

}  // namespace vacuform
