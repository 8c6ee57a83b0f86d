#include "worker/conductors/tail_ink.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/conductors/widened.hpp"
#include "worker/electrical/strip_pair.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double smooth_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Of a lead: how far its middle is from that of the tail, along it.
class LeadMiddle {
 public:
  LeadMiddle(const LeadSizes& sizes, double start_mm, double length_mm)
      : sizes_(sizes),
        leaves_port_(start_mm + sizes.trace_mm / 2),
        spreads_(length_mm - sizes.pad_length_mm - sizes.spread_mm) {}

  double operator()(double along) const {
    const double at_port = (sizes_.port_mm + sizes_.width_mm) / 2,
                 between = (sizes_.between_mm + sizes_.width_mm) / 2;
    return at_port + (between - at_port) * smooth_step((along - leaves_port_) / sizes_.spread_mm) +
           (sizes_.pitch_mm / 2 - between) * smooth_step((along - spreads_) / sizes_.spread_mm);
  }

 private:
  const LeadSizes& sizes_;
  const double leaves_port_, spreads_;
};

class TailInk {
 public:
  TailInk(const TailWay& way, const PartLine& line)
      : way_(way), line_(line), middle_(way.sizes, way.start_mm, line.length()) {}

  std::vector<LaidInkArea> ink(const std::vector<TailBridge>& bridges) const {
    std::vector<LaidInkArea> out;
    for (const double side : {-1.0, 1.0}) {
      double from = 0;
      for (const TailBridge& bridge : bridges) {
        out.push_back(strip(PrintStep::conductor, side, {from, bridge.cut.from}));
        out.push_back(strip(PrintStep::bridges, side, bridge.reach));
        from = bridge.cut.to;
      }
      out.push_back(strip(PrintStep::conductor, side, {from, line_.length()}));
      out.push_back(pad(side));
    }
    return out;
  }

  // On the flat sheet.
  Vector2d pad_middle(double side) const {
    const PartLine::Point at = line_.at(line_.length() - way_.sizes.pad_length_mm / 2);
    const auto found = line_.beside(at, side * way_.sizes.pitch_mm / 2);
    return found ? line_.surface().rest(*found) : at.rest;
  }

 private:
  LaidInkArea strip(PrintStep step, double side, const Interval& part) const {
    const double half = way_.sizes.width_mm / 2;
    LaidInkArea out{.element = way_.loop.element, .step = step, .area = {}, .line = {}};
    out.area = line_.strip(
        part.from, part.to, [&](double along) { return side * middle_(along) - half; },
        [&](double along) { return side * middle_(along) + half; });
    out.width_mm = way_.sizes.width_mm;
    out.line = line_.beside_line(part.from, part.to, [&](double along) { return side * middle_(along); });
    return out;
  }

  LaidInkArea pad(double side) const {
    const double middle = side * way_.sizes.pitch_mm / 2, half = way_.sizes.pad_width_mm / 2;
    LaidInkArea out{.element = way_.loop.element, .area = {}, .line = {}};
    out.area = line_.strip(
        line_.length() - way_.sizes.pad_length_mm, line_.length(), [&](double) { return middle - half; },
        [&](double) { return middle + half; });
    return out;
  }

  const TailWay& way_;
  const PartLine& line_;
  const LeadMiddle middle_;
};

double area_ratio(const InkedSurface& surface, int triangle) {
  const Triangle& t = surface.triangles()[index(triangle)];
  const auto flat = [&](std::size_t k) { return surface.rest()[index(t[k])]; };
  const auto formed = [&](std::size_t k) { return surface.inked()[index(t[k])]; };
  const Vector2d a = flat(1) - flat(0), b = flat(2) - flat(0);
  const double before = std::abs(a.x() * b.y() - a.y() * b.x()),
               after = (formed(1) - formed(0)).cross(formed(2) - formed(0)).norm();
  return before > 0 ? after / before : 1;
}

void measure(const PartLine& line, double start_mm, const Settings& settings, Tail& tail) {
  const std::vector<PartLine::Point>& points = line.points();
  tail.length_mm = line.length() - start_mm;
  tail.inductance_nh = tail.length_mm * strip_pair_nh_per_mm(tail.width_mm, tail.between_mm);
  constexpr std::size_t some = 4;  // about a millimetre
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double formed = points[i + 1].along - points[i].along,
                 flat = (points[i + 1].rest - points[i].rest).norm();
    if (points[i].along < start_mm || !(flat > 0)) continue;
    tail.squares += 2 * formed / tail.width_mm * area_ratio(line.surface(), points[i].at.triangle) *
                    ink_ratio(settings.circuit.ink_stretch, formed / flat);
    const std::size_t on = std::min(points.size() - 1, i + some);
    double flat_on = 0;
    for (std::size_t k = i; k < on; ++k) flat_on += (points[k + 1].rest - points[k].rest).norm();
    tail.most_stretch = std::max(tail.most_stretch, (points[on].along - points[i].along) / flat_on);
  }
}

}  // namespace

std::optional<LaidTail> lead_ink(TailWay way, const InkedSurface& surface, const PlaneLocator& locator,
                                 const std::vector<OtherTrace>& others, const Settings& settings) {
  const PartLine line(surface, locator, way.line);
  if (line.points().size() < 2) return std::nullopt;
  auto crossed = crossed_traces(line, way.sizes, others, settings.coils);
  if (!crossed) return std::nullopt;
  const TailInk lead(way, line);
  LaidTail out;
  Tail& tail = out.tail;
  tail.coil = way.loop.element;
  tail.number = way.port.number;
  tail.line = way.line;
  tail.between_mm = way.sizes.between_mm;
  tail.width_mm = way.sizes.width_mm;
  tail.pads = {lead.pad_middle(-1), lead.pad_middle(1)};
  const PartLine::Point end = line.at(line.length() - way.sizes.pad_length_mm / 2);
  tail.place = end.place;
  tail.rest = end.rest;
  tail.onwards = (line.points().back().rest - end.rest).normalized();
  tail.crossings = std::move(crossed->crossings);
  tail.bridges = std::move(crossed->bridges);
  measure(line, way.start_mm, settings, tail);
  out.ink = lead.ink(tail.bridges);
  out.field = std::move(way.field);
  return out;
}

}  // namespace vacuform
