#include "worker/conductors/electrical_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/conductors/islands.hpp"
#include "worker/conductors/loop_path.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double along_step_mm = 0.1;  // of points along conductors

// Groups of what is joined.
class Groups {
 public:
  explicit Groups(int count) : parent_(index(count)) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int i) {
    while (parent_[index(i)] != i) i = parent_[index(i)] = parent_[index(parent_[index(i)])];
    return i;
  }
  void join(int a, int b) { parent_[index(std::max(of(a), of(b)))] = std::min(of(a), of(b)); }

 private:
  std::vector<int> parent_;
};

// A point with the number of what it belongs to.
struct Labelled {
  Vector3d at;
  int label;
};

// Of every two labels that come within `reach_mm` of each other: how near, and where. The work is limited: of points
// beyond some million that lie together only a part is compared.
struct Near {
  double mm;
  Vector3d at;
};
std::map<std::pair<int, int>, Near> nearest_of_each_pair(const std::vector<Labelled>& points,
                                                         double reach_mm) {
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [&](const Vector3d& p) {
    Cell out{};
    for (std::size_t k = 0; k < 3; ++k)
      out[k] = static_cast<std::int64_t>(std::floor(p[static_cast<Eigen::Index>(k)] / reach_mm));
    return out;
  };
  std::map<Cell, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < points.size(); ++i) cells[cell_of(points[i].at)].push_back(i);
  std::map<std::pair<int, int>, Near> out;
  std::int64_t left = 50'000'000;
  for (const auto& [cell, held] : cells)
    for (std::int64_t n = 0; n < 27; ++n) {
      const auto other = cells.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
      if (other == cells.end() || other->first < cell) continue;
      for (const std::size_t i : held)
        for (const std::size_t k : other->second) {
          if (points[i].label == points[k].label || --left < 0) continue;
          const double mm = (points[i].at - points[k].at).norm();
          if (mm > reach_mm) continue;
          const auto [at, is_new] = out.try_emplace(std::minmax(points[i].label, points[k].label),
                                                    Near{mm, (points[i].at + points[k].at) / 2});
          if (!is_new && mm < at->second.mm) at->second = {mm, (points[i].at + points[k].at) / 2};
        }
    }
  return out;
}

// The ink of one face. Islands of conductor and of bridges have numbers of their own among those of both faces.
struct Face {
  Islands conductor, dielectric, bridges;
  int first_conductor = 0, first_bridge = 0;
  std::vector<std::set<int>> contacts;  // of each bridge: the conductors that it touches
};

// A point of a loop on the sheet.
struct OnLoop {
  double along = 0;
  Vector2d rest{0, 0};
  Vector3d place{0, 0, 0};
  int island = -1;  // of conductor; -1: no ink
  int bridge = -1;  // of the bridges of its face; -1: none
};

struct WalkedLoop {
  int element = 0;
  std::vector<OnLoop> points;
  std::set<int> islands;
};

std::pair<Vector2d, Vector2d> box_of(const Ring& ring) {
  Vector2d low = ring.front(), high = low;
  for (const Vector2d& p : ring) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return {low, high};
}

Face face_of(const std::vector<PrintedInk>& ink, int number, int& islands) {
  Face out;
  for (const PrintedInk& each : ink) {
    if (each.face != number || !of_circuits(each.step)) continue;
    Islands& of = each.step == PrintStep::conductor    ? out.conductor
                  : each.step == PrintStep::dielectric ? out.dielectric
                                                       : out.bridges;
    of = Islands(each.rings);
  }
  out.first_conductor = std::exchange(islands, islands + out.conductor.count());
  out.first_bridge = std::exchange(islands, islands + out.bridges.count());
  for (int b = 0; b < out.bridges.count(); ++b) {
    std::set<int>& contacts = out.contacts.emplace_back();
    const auto [low, high] = box_of(out.bridges.outlines()[index(b)].front());
    constexpr double grid_mm = 0.15;
    for (double x = low.x(); x <= high.x(); x += grid_mm)
      for (double y = low.y(); y <= high.y(); y += grid_mm)
        if (const Vector2d p(x, y); out.bridges.at(p) == b && out.dielectric.at(p) < 0)
          if (const int below = out.conductor.at(p); below >= 0) contacts.insert(out.first_conductor + below);
  }
  return out;
}

class Check {
 public:
  Check(const Drawing& drawing, const Placement& placement, const ArrayBuild& build,
        const std::vector<PrintedInk>& ink)
      : drawing_(drawing), placement_(placement), build_(build) {
    int islands = 0;
    for (int f = 0; f < 2; ++f) faces_[index(f)] = face_of(ink, f, islands);
    groups_ = Groups(islands);
    for (const Face& face : faces_)
      for (int b = 0; b < face.bridges.count(); ++b)
        for (const int conductor : face.contacts[index(b)]) groups_.join(face.first_bridge + b, conductor);
  }

  Result<ElectricalCheck> run(const std::array<const InkedSurface*, 2>& surfaces, double clearance_mm,
                              const Context& context) {
    for (std::size_t i = 0; i < placement_.elements.size(); ++i) {
      VACUFORM_CHECK(context.step(Stage::printing, 0));
      if (drawing_.elements[index(placement_.elements[i].element)].loop) walk(i);
    }
    count_nets();
    for (std::size_t f = 0; f < 2; ++f)
      if (surfaces[f]) {
        VACUFORM_CHECK(context.step(Stage::printing, 0));
        measure(faces_[f].conductor, faces_[f].first_conductor, *surfaces[f], clearance_mm);
        measure(faces_[f].bridges, faces_[f].first_bridge, *surfaces[f], clearance_mm);
      }
    return std::move(found_);
  }

 private:
  const Face& face_of_loop(int element) const { return faces_[index(build_.faces[index(element)])]; }

  std::vector<OnLoop> points_of(std::size_t placed, const LoopPath& path, const Face& face) const {
    const int element = placement_.elements[placed].element;
    const Patch& patch = build_.placement(build_.faces[index(element)], placement_).elements[placed].patch;
    const PlaneLocator locator(patch.triangles, patch.uv);
    const int count = std::max(8, static_cast<int>(std::ceil(path.length() / along_step_mm)));
    std::vector<OnLoop> out;
    for (int i = 0; i < count; ++i) {
      OnLoop& point = out.emplace_back();
      point.along = path.length() * i / count;
      const auto found = locator.nearest(path.at(point.along), 1e-3);
      if (!found) continue;
      point.rest = interpolate(patch.triangles, *found, patch.rest);
      point.place = interpolate(patch.triangles, *found, patch.inked);
      if (const int island = face.conductor.at(point.rest); island >= 0)
        point.island = face.first_conductor + island;
      point.bridge = face.bridges.at(point.rest);
    }
    return out;
  }

  // Goes once round a loop, from a place where nothing else lies.
  void walk(std::size_t placed) {
    const int element = placement_.elements[placed].element;
    const LoopPath path(*drawing_.elements[index(element)].loop);
    const Face& face = face_of_loop(element);
    WalkedLoop loop{element, points_of(placed, path, face), {}};
    std::vector<OnLoop>& points = loop.points;
    const auto inked = [](const OnLoop& p) { return p.island >= 0; };
    auto first = std::find_if(points.begin(), points.end(), [&](const OnLoop& p) {
      return inked(p) && p.bridge < 0 && face.dielectric.at(p.rest) < 0;
    });
    if (first == points.end()) first = std::find_if(points.begin(), points.end(), inked);
    if (first == points.end()) return;  // none of it is printed
    std::rotate(points.begin(), first, points.end());
    points.push_back(points.front());
    loop.islands.insert(points.front().island);
    for (std::size_t i = 0; i + 1 < points.size();) {
      if (points[i + 1].island == points[i].island) {
        ++i;
        continue;
      }
      const std::size_t end = past_break(loop, path, face, i);
      if (end == 0) {
        i = static_cast<std::size_t>(
            std::find_if(points.begin() + static_cast<std::ptrdiff_t>(i) + 1, points.end(), inked) -
            points.begin());
        found_.opens.push_back({element, element, points[i].place, 0});
      } else {
        i = end;
      }
      loop.islands.insert(points[i].island);
    }
    loops_.push_back(std::move(loop));
  }

  // The ink of the loop ends behind a point. Where it goes on, over a capacitor or a bridge; 0: nowhere.
  std::size_t past_break(const WalkedLoop& loop, const LoopPath& path, const Face& face, std::size_t from) {
    const std::vector<OnLoop>& points = loop.points;
    const int island = points[from].island;
    if (const int bridge = points[from].bridge; bridge >= 0) {
      std::size_t to = from;
      while (to + 1 < points.size() && points[to + 1].bridge == bridge) ++to;
      const std::set<int>& contacts = face.contacts[index(bridge)];
      if (to > from && contacts.contains(island) && contacts.contains(points[to].island)) return to;
    }
    std::size_t to = from + 1;
    while (points[to].island < 0) ++to;
    const double middle = points[from].along + path.round(points[to].along - points[from].along) / 2;
    for (const LoopGap& gap : build_.gaps)
      if (gap.coil == loop.element && apart_on_loop(gap.along.middle(), middle, path.length()) <=
                                          gap.along.length() / 2 + along_step_mm) {
        groups_.join(island, points[to].island);
        return to;
      }
    return 0;
  }

  void count_nets() {
    std::map<int, std::vector<const WalkedLoop*>> nets;
    for (const WalkedLoop& loop : loops_) {
      std::set<int> of_loop;
      for (const int island : loop.islands) of_loop.insert(groups_.of(island));
      for (const int net : of_loop) nets[net].push_back(&loop);
    }
    found_.loops = static_cast<int>(loops_.size());
    found_.nets = static_cast<int>(nets.size());
    for (const auto& [net, loops] : nets) {
      first_loop_[net] = loops.front()->element;
      add_shorts(loops);
    }
    add_plates();
    add_tails();
    std::sort(found_.shorts.begin(), found_.shorts.end(),
              [](const auto& x, const auto& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  }

  // Of the loops of one net: those whose traces touch, and those that are joined by something else.
  void add_shorts(const std::vector<const WalkedLoop*>& loops) {
    if (loops.size() < 2) return;
    std::vector<Labelled> points;
    std::map<int, double> half_width;
    for (const WalkedLoop* loop : loops) {
      half_width[loop->element] = width_on_part(loop->element) / 2;
      for (std::size_t i = 0; i < loop->points.size(); i += 4)
        if (loop->points[i].island >= 0) points.push_back({loop->points[i].place, loop->element});
    }
    double widest = 0;
    for (const auto& [element, half] : half_width) widest = std::max(widest, half);
    std::set<int> paired;
    for (const auto& [pair, near] : nearest_of_each_pair(points, 2 * widest + 4 * along_step_mm)) {
      if (near.mm > half_width[pair.first] + half_width[pair.second] + 4 * along_step_mm) continue;
      paired.insert({pair.first, pair.second});
      found_.shorts.push_back({pair.first, pair.second, near.at, 0});
    }
    const WalkedLoop& first = *loops.front();
    for (const WalkedLoop* loop : loops)
      if (!paired.contains(loop->element) && loop != &first)
        found_.shorts.push_back({first.element, loop->element, loop->points.front().place, 0});
  }

  // A plate is a conductor of its own, that must touch no loop of its face.
  void add_plates() {
    for (const LoopGap& gap : build_.gaps) {
      if (!gap.plate) continue;
      const Face& face = faces_[index(1 - build_.faces[index(gap.coil)])];
      const int island = face.conductor.at(gap.plate->rest);
      if (island < 0) {
        found_.opens.push_back({gap.coil, gap.coil, gap.place, 0});
        continue;
      }
      const auto [net, is_new] = first_loop_.try_emplace(groups_.of(face.first_conductor + island), gap.coil);
      if (!is_new)
        found_.shorts.push_back(
            {std::min(gap.coil, net->second), std::max(gap.coil, net->second), gap.place, 0});
    }
  }

  // Both pads of a tail are joined to its loop.
  void add_tails() {
    for (const Tail& tail : build_.tails) {
      const auto loop = std::find_if(loops_.begin(), loops_.end(),
                                     [&](const WalkedLoop& each) { return each.element == tail.coil; });
      if (loop == loops_.end()) continue;
      const Face& face = face_of_loop(tail.coil);
      const auto joined = [&](const Vector2d& pad) {
        const int island = face.conductor.at(pad);
        return island >= 0 && std::any_of(loop->islands.begin(), loop->islands.end(), [&](int of_loop) {
                 return groups_.of(of_loop) == groups_.of(face.first_conductor + island);
               });
      };
      if (!joined(tail.pads[0]) || !joined(tail.pads[1]))
        found_.opens.push_back({tail.coil, tail.coil, tail.place, 0});
    }
  }

  double width_on_part(int element) const {
    const auto placed = std::find_if(placement_.elements.begin(), placement_.elements.end(),
                                     [&](const PlacedElement& each) { return each.element == element; });
    return drawing_.elements[index(element)].loop->width_mm * placed->size;
  }

  // Islands of different nets that are too near to each other on a layer.
  void measure(const Islands& islands, int first, const InkedSurface& surface, double clearance_mm) {
    const PlaneLocator locator(surface.triangles(), surface.rest());
    std::vector<Labelled> points;
    for (int i = 0; i < islands.count(); ++i) {
      const int net = groups_.of(first + i);
      if (!first_loop_.contains(net)) continue;
      for (const Ring& ring : islands.outlines()[index(i)])
        for (std::size_t k = 0; k < ring.size(); ++k) {
          const Vector2d &a = ring[k], &b = ring[(k + 1) % ring.size()];
          const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / along_step_mm)));
          for (int j = 0; j < pieces; ++j)
            if (const auto at = locator.find(a + (b - a) * j / pieces))
              points.push_back({surface.place(*at), net});
        }
    }
    for (const auto& [pair, near] : nearest_of_each_pair(points, clearance_mm)) {
      const auto [a, b] = std::minmax(first_loop_.at(pair.first), first_loop_.at(pair.second));
      if (near.mm < clearance_mm) found_.close.push_back({a, b, near.at, near.mm});
    }
  }

  const Drawing& drawing_;
  const Placement& placement_;
  const ArrayBuild& build_;
  std::array<Face, 2> faces_;
  Groups groups_{0};
  std::vector<WalkedLoop> loops_;
  std::map<int, int> first_loop_;  // of each net
  ElectricalCheck found_;
};

std::string names(const Drawing& drawing, const std::vector<ElectricalCheck::Place>& places) {
  std::string out;
  std::set<std::pair<int, int>> said;
  for (const auto& each : places) {
    if (!said.emplace(each.a, each.b).second) continue;
    if (!out.empty()) out += ", ";
    out += drawing.elements[index(each.a)].id;
    if (each.b != each.a) out += " and " + drawing.elements[index(each.b)].id;
  }
  return out;
}

Warning about(const Drawing& drawing, const char* code, const std::vector<ElectricalCheck::Place>& places) {
  Warning out{.code = code, .text = {}};
  for (const auto& each : places)
    if (out.marks.size() < Warning::most_marks)
      out.marks.push_back({{each.at.x(), each.at.y(), each.at.z()}, 5});
  out.place = names(drawing, places);
  out.figure = Warning::Figure{static_cast<double>(places.size()), "", 0.0};
  return out;
}

}  // namespace

std::vector<Warning> ElectricalCheck::warnings(const Drawing& drawing, double clearance_mm) const {
  std::vector<Warning> out;
  const auto counted = [](std::size_t count, const char* one, const char* several) {
    return std::to_string(count) + (count == 1 ? one : several);
  };
  if (!shorts.empty()) {
    Warning& warning = out.emplace_back(about(drawing, "coils-short", shorts));
    warning.text = counted(shorts.size(), " pair of loops is", " pairs of loops are") +
                   " joined by ink: " + std::to_string(loops) + " loops are " + std::to_string(nets) +
                   (nets == 1 ? " circuit" : " circuits");
    if (drawing.parts_loops())
      warning.fix =
          "Look at the layers of the drawing: where loops cross, one is interrupted, and a patch of "
          "dielectric and a bridge are "
          "drawn on layers with these names, or the loops are drawn on different faces.";
  }
  if (!opens.empty()) {
    Warning& warning = out.emplace_back(about(drawing, "coils-open", opens));
    warning.text = counted(opens.size(), " place of a loop has", " places of loops have") +
                   " no ink, no bridge and no gap for a capacitor";
  }
  if (!close.empty()) {
    const auto nearest = std::min_element(close.begin(), close.end(),
                                          [](const Place& a, const Place& b) { return a.mm < b.mm; });
    Warning& warning = out.emplace_back(about(drawing, "coils-close", close));
    warning.text = counted(close.size(), " pair of circuits comes", " pairs of circuits come") +
                   " nearer to each other than coils.clearance_mm on the part, at least " +
                   decimal(nearest->mm, 2) + " mm apart";
    warning.figure = Warning::Figure{nearest->mm, "mm", clearance_mm};
  }
  return out;
}

Result<ElectricalCheck> check_conductors(const Drawing& drawing, const Placement& placement,
                                         const ArrayBuild& build, const std::vector<PrintedInk>& ink,
                                         const std::array<const InkedSurface*, 2>& surfaces,
                                         double clearance_mm, const Context& context) {
  return Check(drawing, placement, build, ink).run(surfaces, clearance_mm, context);
}

}  // namespace vacuform
