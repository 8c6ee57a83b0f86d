#include "worker/conductors/bridges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "worker/conductors/loop_path.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using TraceOf = std::function<const Trace&(int)>;

Bridge bridge_of(const Crossing& crossing, bool a_over, const TraceOf& trace_of, const BridgeSizes& sizes) {
  Bridge out{.crossing = crossing, .a_over = a_over};
  const Trace &over = trace_of(out.over()), &under = trace_of(out.under());
  const auto along_over = [&](double beyond) {
    return over.clear_of(out.along_over(), under, out.along_under(), beyond);
  };
  constexpr double tolerance_mm = 0.05;  // of the steps of this search, and of curves on the sheet
  out.cut = along_over(sizes.clearance + tolerance_mm);
  out.reach = std::max(out.cut, along_over(sizes.margin)) + sizes.overlap / over.scale();
  out.patch = under.clear_of(out.along_under(), over, out.along_over(), sizes.margin);
  return out;
}

// The two choices at each crossing, and the crossings along each loop.
class Choice {
 public:
  Choice(const std::vector<Crossing>& crossings, const TraceOf& trace_of, const BridgeSizes& sizes)
      : choices_(crossings.size()), chosen_(crossings.size(), 0) {
    in_parallel(0, static_cast<int>(crossings.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i)
        choices_[index(i)] = {bridge_of(crossings[index(i)], false, trace_of, sizes),
                              bridge_of(crossings[index(i)], true, trace_of, sizes)};
    });
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const Crossing& c = crossings[i];
      for (const int loop : {c.a, c.b}) on_loop_[loop].length = trace_of(loop).path().length();
      on_loop_[c.a].places.push_back({c.along_a, i, true});
      on_loop_[c.b].places.push_back({c.along_b, i, false});
      longest_ = std::max(
          {longest_, choices_[i][0].reach, choices_[i][1].reach, choices_[i][0].patch, choices_[i][1].patch});
    }
    for (auto& [loop, held] : on_loop_)
      std::sort(held.places.begin(), held.places.end(), [](const Place& x, const Place& y) {
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
    const OnLoop& of = on_loop_.at(loop);
    const std::vector<Place>& places = of.places;
    const double length = of.length;
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

  struct OnLoop {
    std::vector<Place> places;
    double length = 0;
  };
  std::map<int, OnLoop> on_loop_;
  std::vector<std::array<Bridge, 2>> choices_;
  std::vector<std::size_t> chosen_;
  double longest_ = 0;
};

}  // namespace

Bridges choose_bridges(const std::vector<Crossing>& crossings, const TraceOf& trace_of,
                       const BridgeSizes& sizes) {
  Choice choice(crossings, trace_of, sizes);
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
