#include "worker/conductors/tails.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "worker/conductors/cheapest_way.hpp"
#include "worker/conductors/tail_crossings.hpp"
#include "worker/conductors/tail_ground.hpp"
#include "worker/conductors/tail_ink.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

// What a millimetre costs near the trace of another loop, over a tail on the other face, and within this distance of anything.
constexpr float crossing_cost = 8, beneath_cost = 3, crowded_cost = 1.5;
constexpr double crowded_mm = 1.5;
constexpr double leaves_head_mm = 2;  // how far beyond the chart the pads begin, on the part
constexpr double frame_mm = 4;  // pads keep this far from the window of the clamp frame, on the flat sheet

class TailPlan {
 public:
  TailPlan(const ArraySoFar& array, const Settings& settings)
      : array_(array),
        coils_(settings.coils),
        settings_(settings),
        locator_(array.sides[0]->surface().triangles(), array.sides[0]->surface().rest()) {}

  Result<TailLayout> run(const Context& context) {
    std::vector<std::size_t> order = by_distance();
    for (int round = 0; round < most_rounds; ++round) {
      VACUFORM_TRY(tails, lay_all(order, context));
      std::vector<std::size_t> without, with;
      for (const std::size_t i : order) (tails[i] ? with : without).push_back(i);
      if (round == 0 || without.size() < left_out_) left_out_ = without.size(), best_ = std::move(tails);
      if (without.empty()) break;
      without.insert(without.end(), with.begin(), with.end());
      if (without == order) break;
      order = std::move(without);
    }
    return result(by_distance());
  }

 private:
  static constexpr int most_rounds = 4;

  const LoopGap* port_of(const LaidLoop& loop) const {
    const auto at = std::find_if(array_.gaps.begin(), array_.gaps.end(),
                                 [&](const LoopGap& gap) { return gap.port && gap.coil == loop.element; });
    return at == array_.gaps.end() ? nullptr : &*at;
  }
  int face_of(const LaidLoop& loop) const { return array_.faces[index(loop.element)]; }
  double width_of(std::size_t i) const { return array_.loops[i].trace->width_mm() * array_.widest[i]; }
  double margin() const { return tail_margin_mm(coils_); }

  // Between the leads: the width of the port, within what can be printed and soldered.
  LeadSizes sizes_of(std::size_t i) const {
    const LaidLoop& loop = array_.loops[i];
    const double port = port_of(loop)->along.length() * loop.trace->scale();
    return lead_sizes(coils_, port, width_of(i));
  }

  TailGround& ground(int face) {
    std::unique_ptr<TailGround>& out = grounds_[index(face)];
    if (!out) out = make_ground(face);
    return *out;
  }

  std::unique_ptr<TailGround> make_ground(int face) const {
    const ChartedSurface& side = *array_.sides[index(face)];
    Eigen::AlignedBox2d box;
    for (const int t : side.flattening().triangles)
      for (const int v : side.surface().triangles()[index(t)]) box.extend(side.surface().rest()[index(v)]);
    constexpr double around_mm = 30;
    box = Eigen::AlignedBox2d(box.min() - Vector2d::Constant(around_mm),
                              box.max() + Vector2d::Constant(around_mm));
    double widest = 0;
    for (std::size_t i = 0; i < array_.loops.size(); ++i)
      if (port_of(array_.loops[i])) widest = std::max(widest, sizes_of(i).field_mm() / 2);
    auto out = std::make_unique<TailGround>(side, box, widest + margin() + tail_slack_mm + crowded_mm);
    for (std::size_t i = 0; i < array_.loops.size(); ++i) add_loop(i, face, *out);
    for (const LaidInkArea& ink : array_.other)
      if (ink.face == face) out->add_ink(loop_of(ink.element), Islands(ink.area));
    return out;
  }

  int loop_of(int element) const {
    for (std::size_t i = 0; i < array_.loops.size(); ++i)
      if (array_.loops[i].element == element) return static_cast<int>(i);
    return -1;
  }

  void add_loop(std::size_t i, int face, TailGround& out) const {
    const LaidLoop& loop = array_.loops[i];
    const int number = static_cast<int>(i);
    const bool here = face_of(loop) == face;
    if (here) {
      out.add_trace(number, TailGround::Kind::crossable, *loop.trace, {0, loop.trace->path().length()},
                    width_of(i));
      for (const Interval& part : loop.covered) {
        // Its ends are square, those of a stamped line round.
        const double wide = width_of(i) + 2 * coils_.patch_margin_mm,
                     shorter = std::min(0.45 * part.length(), 0.35 * wide / loop.trace->scale());
        out.add_trace(number, TailGround::Kind::closed, *loop.trace, {part.from + shorter, part.to - shorter},
                      wide);
      }
    }
    const Pads pads = pads_of(coils_);
    for (const LoopGap& gap : array_.gaps) {
      if (gap.coil != loop.element || (!here && !gap.plate)) continue;
      const double ends = pads.length / loop.trace->scale(), before = gap.plate ? gap.plate->before : ends,
                   after = gap.plate ? gap.plate->after : ends,
                   wide = gap.plate ? coils_.plate_width_mm + 2 * plate_margin_mm : pads.width;
      const Interval along{gap.along.from - before, gap.along.to + after};
      if (gap.port)
        out.add_port(number, *loop.trace, along, std::max(wide, width_of(i)));
      else
        out.add_trace(number, TailGround::Kind::closed, here ? *loop.trace : *loop.far, along,
                      std::max(wide, width_of(i)));
    }
  }

  // Of the loops with a port, those whose ports are nearest to the edge first.
  std::vector<std::size_t> by_distance() {
    std::vector<std::pair<double, std::size_t>> far;
    for (std::size_t i = 0; i < array_.loops.size(); ++i) {
      const LoopGap* const port = port_of(array_.loops[i]);
      if (!port) continue;
      double least = 1e9;
      for (const Eigen::Vector3d& p : array_.sides[0]->border())
        least = std::min(least, (p - port->place).squaredNorm());
      far.emplace_back(least, i);
    }
    std::sort(far.begin(), far.end());
    std::vector<std::size_t> out;
    for (const auto& [mm, i] : far) out.push_back(i);
    return out;
  }

  Result<std::vector<std::optional<LaidTail>>> lay_all(const std::vector<std::size_t>& order,
                                                       const Context& context) {
    for (const std::size_t i : order) ground(face_of(array_.loops[i]));
    for (const auto& each : grounds_)
      if (each) each->remove_lines();
    std::vector<std::optional<LaidTail>> out(array_.loops.size());
    for (const std::size_t i : order) {
      if (context.cancelled()) return fail(Code::cancelled, "cancelled");
      out[i] = lay(i);
      if (!out[i]) continue;
      const LeadSizes sizes = sizes_of(i);
      for (const int face : {0, 1}) {
        if (!grounds_[index(face)]) continue;
        // Pads lie apart on both faces, and so do leads where that costs little.
        const bool here = face == face_of(array_.loops[i]);
        grounds_[index(face)]->add_line(out[i]->tail.line, sizes.pair_mm(),
                                        here ? TailGround::Kind::closed : TailGround::Kind::beneath);
        grounds_[index(face)]->add_line(out[i]->field, sizes.field_mm(), TailGround::Kind::closed);
      }
    }
    return out;
  }

  // The sector of the sheet's border where tails may end.
  bool is_exit(const Vector2d& p, const Vector2d& middle) const {
    if (coils_.tails == TailExit::nearest) return true;
    const Vector2d to(0, coils_.tails == TailExit::front ? 1 : -1);
    constexpr double cosine = 0.64;  // of 50 degrees
    return (p - middle).dot(to) >= cosine * (p - middle).norm();
  }

  bool in_window(const Vector2d& p) const {
    const MachineSettings& machine = settings_.machine;
    if (machine.window == WindowShape::circle) return p.norm() <= machine.window_width_mm / 2 - frame_mm;
    return std::abs(p.x()) <= machine.window_width_mm / 2 - frame_mm &&
           std::abs(p.y()) <= machine.window_height_mm / 2 - frame_mm;
  }

  WayCosts costs_for(const TailGround& on, const TailGround::Rooms& rooms, double room_mm) const {
    const SheetCells& cells = on.cells();
    WayCosts out(index(cells.count()), 0);
    for (int c = 0; c < cells.count(); ++c) {
      const std::size_t k = index(c);
      const float nearest = std::min(rooms.closed[k], rooms.own[k]);
      if (cells.triangle(c) < 0 || !(nearest >= room_mm) || !std::isfinite(on.off_chart()[k])) continue;
      if (on.off_chart()[k] > 0 && !in_window(cells.middle(c))) continue;
      out[k] = rooms.crossable[k] < room_mm                                   ? crossing_cost
               : rooms.beneath[k] < room_mm                                   ? beneath_cost
               : std::min(nearest, rooms.crossable[k]) < room_mm + crowded_mm ? crowded_cost
                                                                              : 1;
    }
    return out;
  }

  // The first place outside of the loop, straight across its trace, where a tail is clear of it.
  std::optional<Vector2d> clear_of_own(const LoopGap& port, const TailGround& on, const WayCosts& costs,
                                       const TailGround::Rooms& rooms) const {
    constexpr double step_mm = 0.1, most_mm = 25;
    std::optional<Vector2d> out;
    double own = 0;
    for (double mm = 0; mm < most_mm; mm += step_mm) {
      const Vector2d p = port.rest - mm * port.inwards;
      const int cell = on.cells().at(p);
      if (cell < 0 || !(rooms.closed[index(cell)] > coils_.clearance_mm)) break;
      if (!(costs[index(cell)] > 0)) {
        if (out) break;
        continue;
      }
      // A little farther, so that the tail can turn on a wide arc.
      if (!out) own = rooms.own[index(cell)];
      if (rooms.own[index(cell)] > own + 1.5F) break;
      out = p;
    }
    return out;
  }

  // The middle of the pads and of the leads that spread to them, straight on from a place beside the chart; empty: no room.
  struct Onwards {
    Vector2d from, way;
  };
  std::vector<Vector2d> field_from(const Onwards& onwards, const TailGround& on,
                                   const TailGround::Rooms& rooms, const LeadSizes& sizes) const {
    const Vector2d& way = onwards.way;
    if (!(way.norm() > 0)) return {};
    constexpr double step_mm = 0.2;
    std::vector<Vector2d> out{onwards.from};
    double mm = 0;
    const double clear = sizes.field_mm() / 2 + coils_.clearance_mm + tail_slack_mm;
    while (mm < sizes.spread_mm + sizes.pad_length_mm) {
      const int at = on.cells().at(out.back());
      if (at < 0 || !(on.off_chart()[index(at)] > 0) || !in_window(out.back())) return {};
      const std::size_t k = index(at);
      if (std::min({rooms.closed[k], rooms.own[k], rooms.crossable[k], rooms.beneath[k]}) < clear) return {};
      const double on_part = on.cells().on_part(at, step_mm * way);
      mm += on_part;
      out.push_back(out.back() + step_mm * way);
    }
    return out;
  }

  std::optional<LaidTail> lay(std::size_t i) {
    const LaidLoop& loop = array_.loops[i];
    const LoopGap& port = *port_of(loop);
    const TailGround& on = ground(face_of(loop));
    const LeadSizes sizes = sizes_of(i);
    const double clear = sizes.pair_mm() / 2 + margin(), room = clear + tail_slack_mm;
    const TailGround::Rooms rooms = on.rooms_for(static_cast<int>(i));
    const WayCosts costs = costs_for(on, rooms, room);
    const auto from = clear_of_own(port, on, costs, rooms);
    if (!from) return std::nullopt;
    const Vector2d middle = array_.sides[0]->flattening().top_rest;
    std::vector<Vector2d> field;
    const auto is_end = [&](int cell) {
      const float off = on.off_chart()[index(cell)];
      if (off < leaves_head_mm || off > leaves_head_mm + 1 || !is_exit(on.cells().middle(cell), middle))
        return false;
      field = field_from({on.cells().middle(cell), on.outwards(cell)}, on, rooms, sizes);
      return !field.empty();
    };
    auto way = cheapest_way(on.cells(), costs, *from, is_end);
    if (!way) return std::nullopt;
    // The tail ends straight if it can.
    if (const Vector2d arrives = (way->back() - (*way)[way->size() - 2]).normalized();
        arrives.dot(field.back() - field.front()) > 0)
      if (auto straight = field_from({way->back(), arrives}, on, rooms, sizes); !straight.empty())
        field = std::move(straight);
    // From within the trace, which the leads are to touch.
    const double start = 0.35 * width_of(i),
                 flat = on.cells().on_part(on.cells().at(port.rest), port.inwards);
    way->insert(way->begin(), port.rest + start / flat * port.inwards);
    way->push_back(field.back());
    const auto line =
        with_round_corners(*way, 1.5 * sizes.pair_mm(), [&](std::size_t corner, const Vector2d& p) {
          const int cell = on.cells().at(p);
          if (cell < 0) return false;
          const std::size_t k = index(cell);
          return rooms.closed[k] >= clear && (corner == 1 || rooms.own[k] >= clear);
        });
    return lead_ink({loop, port, line, start, sizes, std::move(field)}, on.surface(), locator_, others(i),
                    settings_);
  }

  std::vector<OtherTrace> others(std::size_t i) const {
    std::vector<OtherTrace> out;
    for (std::size_t k = 0; k < array_.loops.size(); ++k)
      if (k != i && face_of(array_.loops[k]) == face_of(array_.loops[i]))
        out.push_back({array_.loops[k].element, array_.loops[k].trace.get(), width_of(k)});
    return out;
  }

  TailLayout result(const std::vector<std::size_t>& with_port) {
    TailLayout out;
    for (std::size_t i = 0; i < best_.size(); ++i) {
      if (best_[i]) {
        for (LaidInkArea& ink : best_[i]->ink) {
          ink.face = face_of(array_.loops[i]);
          out.ink.push_back(std::move(ink));
        }
        out.tails.push_back(std::move(best_[i]->tail));
      } else if (std::find(with_port.begin(), with_port.end(), i) != with_port.end()) {
        out.left_out.push_back(array_.loops[i].element);
      }
    }
    return out;
  }

  const ArraySoFar& array_;
  const CoilSettings& coils_;
  const Settings& settings_;
  const PlaneLocator locator_;  // of the flat sheet, the same for both faces
  std::array<std::unique_ptr<TailGround>, 2> grounds_;
  std::vector<std::optional<LaidTail>> best_;
  std::size_t left_out_ = 0;
};

}  // namespace

double tail_ohm(const Tail& tail, const CircuitSettings& settings) {
  return tail.squares * settings.ink_mohm / 1000;
}

Result<TailLayout> lay_tails(const ArraySoFar& array, const Settings& settings, const Context& context) {
  return TailPlan(array, settings).run(context);
}

}  // namespace vacuform
