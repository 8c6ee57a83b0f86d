#include "worker/conductors/bridges.hpp"

#include <algorithm>
#include <cmath>

#include "worker/conductors/loop_path.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

Bridge bridge_of(const Crossing& crossing, bool a_over, const std::vector<TraceOnPart>& traces,
                 const BridgeSizes& sizes) {
  Bridge out{.crossing = crossing, .a_over = a_over};
  const TraceOnPart &over = traces[index(out.over())], &under = traces[index(out.under())];
  // A trace that crosses at an angle is longer across the other, and its edges are askew.
  const double sine = crossing.sine, slant = std::sqrt(std::max(0.0, 1 - sine * sine)) / sine;
  const auto across = [&](const TraceOnPart& other, double beyond, const TraceOnPart& own) {
    return ((other.width_mm / 2 + beyond) / sine + own.width_mm / 2 * slant) / own.scale;
  };
  out.cut = across(under, sizes.clearance, over);
  out.reach = std::max(out.cut, across(under, sizes.margin, over)) + sizes.overlap / over.scale;
  out.patch = across(over, sizes.margin, under);
  return out;
}

// The two choices at each crossing, and the crossings along each loop.
class Choice {
 public:
  Choice(const std::vector<Crossing>& crossings, const std::vector<TraceOnPart>& traces, const BridgeSizes& sizes)
      : traces_(traces), on_loop_(traces.size()), chosen_(crossings.size(), 0) {
    for (const Crossing& crossing : crossings)
      choices_.push_back({bridge_of(crossing, false, traces, sizes), bridge_of(crossing, true, traces, sizes)});
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const Crossing& c = crossings[i];
      on_loop_[index(c.a)].push_back({c.along_a, i, true});
      on_loop_[index(c.b)].push_back({c.along_b, i, false});
      longest_ = std::max({longest_, choices_[i][0].reach, choices_[i][1].reach, choices_[i][0].patch,
                           choices_[i][1].patch});
    }
    for (auto& places : on_loop_)
      std::sort(places.begin(), places.end(), [](const Place& x, const Place& y) {
        return std::pair(x.along, x.crossing) < std::pair(y.along, y.crossing);
      });
  }

  const Bridge& chosen(std::size_t i) const { return choices_[i][chosen_[i]]; }
  void flip(std::size_t i) { chosen_[i] ^= 1; }

  // Ends of bridges that lie on patches around the crossing, on both of its loops.
  int crowded(std::size_t i) const {
    const Crossing& c = choices_[i][0].crossing;
    return crowded(c.a, {c.along_a, i, true}) + crowded(c.b, {c.along_b, i, false});
  }

 private:
  struct Place {
    double along;
    std::size_t crossing;
    bool of_a;  // the loop is `a` of the crossing
  };
  bool over(const Place& place) const { return chosen(place.crossing).a_over == place.of_a; }
  double reach(const Place& place) const {
    return over(place) ? chosen(place.crossing).reach : chosen(place.crossing).patch;
  }
  int crowded(int loop, const Place& place) const {
    const std::vector<Place>& places = on_loop_[index(loop)];
    const double length = traces_[index(loop)].length;
    int count = 0;
    const auto look = [&](double from, double to) {
      auto at = std::lower_bound(places.begin(), places.end(), from,
                                 [](const Place& p, double along) { return p.along < along; });
      for (; at != places.end() && at->along <= to; ++at)
        if (at->crossing != place.crossing && over(*at) != over(place) &&
            apart_on_loop(at->along, place.along, length) < reach(*at) + reach(place))
          ++count;
    };
    const double far = std::min(2 * longest_, length / 2), from = place.along - far, to = place.along + far;
    look(std::max(from, 0.0), std::min(to, length));
    if (from < 0) look(from + length, length);
    if (to > length) look(0, to - length);
    return count;
  }

  const std::vector<TraceOnPart>& traces_;
  std::vector<std::vector<Place>> on_loop_;
  std::vector<std::array<Bridge, 2>> choices_;
  std::vector<std::size_t> chosen_;
  double longest_ = 0;
};

}  // namespace

Bridges choose_bridges(const std::vector<Crossing>& crossings, const std::vector<TraceOnPart>& traces,
                       const BridgeSizes& sizes) {
  Choice choice(crossings, traces, sizes);
  constexpr int most_rounds = 50;
  bool better = true;
  for (int round = 0; better && round < most_rounds; ++round) {
    better = false;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const int before = choice.crowded(i);
      if (before == 0) continue;
      choice.flip(i);
      if (choice.crowded(i) < before)
        better = true;
      else
        choice.flip(i);
    }
  }
  Bridges out;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    out.bridges.push_back(choice.chosen(i));
    out.crowded += choice.crowded(i);
  }
  out.crowded /= 2;  // each counts at both of its crossings
  return out;
}

}  // namespace vacuform
