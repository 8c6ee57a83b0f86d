#include "worker/conductors/tail_ground.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr float beside_mm = 40;  // how far from the chart tails may end

std::vector<Vector2d> rest_points(const Trace& trace, const Interval& along) {
  constexpr double between_mm = 0.4;
  std::vector<Vector2d> out;
  const int count = std::max(1, static_cast<int>(std::ceil(along.length() * trace.scale() / between_mm)));
  for (int i = 0; i <= count; ++i)
    if (const auto at = trace.rest(along.from + along.length() * i / count)) out.push_back(*at);
  return out;
}

}  // namespace

TailGround::TailGround(const ChartedSurface& charted, const Eigen::AlignedBox2d& box, double reach_mm)
    : charted_(charted),
      cells_(charted.surface(), box),
      reach_mm_(reach_mm),
      off_chart_(cells_.open_ground()),
      scratch_(cells_.open_ground()) {
  find_off_chart();
}

void TailGround::find_off_chart() {
  using Open = std::pair<float, int>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  std::fill(off_chart_.begin(), off_chart_.end(), std::numeric_limits<float>::infinity());
  for (int cell = 0; cell < cells_.count(); ++cell)
    if (const int t = cells_.triangle(cell); t >= 0 && charted_.on_chart(t)) {
      off_chart_[index(cell)] = 0;
      open.emplace(0.0F, cell);
    }
  while (!open.empty()) {
    const auto [mm, cell] = open.top();
    open.pop();
    if (mm > off_chart_[index(cell)]) continue;
    for (const int next : cells_.neighbours(cell)) {
      const auto sum =
          static_cast<float>(mm + cells_.on_part(next, cells_.middle(next) - cells_.middle(cell)));
      if (!(sum < off_chart_[index(next)]) || sum > beside_mm) continue;
      off_chart_[index(next)] = sum;
      open.emplace(sum, next);
    }
  }
}

Vector2d TailGround::outwards(int cell) const {
  // The slope of the distance from the chart over a disc, so that the steps of the chart's border do not show.
  constexpr double radius_mm = 8;
  const int reach = static_cast<int>(radius_mm / SheetCells::size_mm);
  Vector2d out(0, 0);
  const Vector2d middle = cells_.middle(cell);
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      const Vector2d way = SheetCells::size_mm * Vector2d(i, j);
      const int other = cells_.at(middle + way);
      if (other < 0 || way.norm() > radius_mm || !std::isfinite(off_chart_[index(other)])) continue;
      out += static_cast<double>(off_chart_[index(other)] - off_chart_[index(cell)]) * way;
    }
  return out.norm() > 0 ? Vector2d(out.normalized()) : out;
}

TailGround::Thing& TailGround::add(int loop, Kind kind, const std::vector<Vector2d>& points,
                                   double width_mm) {
  Thing& thing = things_.emplace_back(Thing{.loop = loop, .kind = kind, .room = {}});
  std::vector<int> touched;
  for (const Vector2d& p : points) cells_.keep_clear({p, width_mm / 2, reach_mm_}, scratch_, touched);
  for (const int cell : touched)
    thing.room.emplace_back(cell, std::exchange(scratch_[index(cell)], SheetCells::open));
  return thing;
}

void TailGround::add_trace(int loop, Kind kind, const Trace& trace, const Interval& along, double width_mm) {
  add(loop, kind, rest_points(trace, along), width_mm);
}

void TailGround::add_port(int loop, const Trace& trace, const Interval& along, double width_mm) {
  add(loop, Kind::closed, rest_points(trace, along), width_mm).port = true;
}

void TailGround::add_ink(int loop, const Islands& ink) {
  for (const Area& outline : ink.outlines()) {
    std::vector<Vector2d> points;
    Eigen::AlignedBox2d around;
    for (const Ring& ring : outline)
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
        const int count = std::max(1, static_cast<int>(std::ceil((b - a).norm() / SheetCells::size_mm)));
        for (int k = 0; k < count; ++k) points.push_back(a + (b - a) * k / count);
        around.extend(a);
      }
    Thing& thing = add(loop, Kind::closed, points, 0);
    thing.ink = true;
    for (double y = around.min().y(); y <= around.max().y(); y += SheetCells::size_mm)
      for (double x = around.min().x(); x <= around.max().x(); x += SheetCells::size_mm)
        if (const int cell = cells_.at({x, y}); cell >= 0 && ink.at(cells_.middle(cell)) >= 0)
          thing.room.emplace_back(cell, -1.0F);
  }
}

void TailGround::add_line(const std::vector<Vector2d>& line, double width_mm, Kind kind) {
  add(-1, kind, line, width_mm).line = true;
}

void TailGround::remove_lines() {
  std::erase_if(things_, [](const Thing& thing) { return thing.line; });
}

TailGround::Rooms TailGround::rooms_for(int loop) const {
  Rooms out{cells_.open_ground(), cells_.open_ground(), cells_.open_ground(), cells_.open_ground()};
  for (const Thing& thing : things_) {
    const bool own = thing.loop == loop;
    if (own && thing.port) continue;
    Room& room = own && (thing.ink || thing.kind == Kind::crossable) ? out.own
                 : thing.kind == Kind::crossable                     ? out.crossable
                 : thing.kind == Kind::beneath                       ? out.beneath
                                                                     : out.closed;
    for (const auto& [cell, mm] : thing.room) room[index(cell)] = std::min(room[index(cell)], mm);
  }
  return out;
}

}  // namespace vacuform
