#include "worker/conductors/covered_pads.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "worker/conductors/islands.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

// What covers the circuits of a face.
Islands cover_of(const std::vector<PrintedInk>& ink, int face) {
  std::vector<Ring> rings;
  for (const PrintedInk& each : ink)
    if (each.face == face && !of_circuits(each.step))
      rings.insert(rings.end(), each.rings.begin(), each.rings.end());
  return Islands(rings);
}

// Whether a port is soldered elsewhere, at the pads of its tail; then, whether something covers one of these.
std::optional<bool> has_covered_tail(const std::vector<Tail>& tails, const LoopGap& gap,
                                     const Islands& cover) {
  const auto tail = std::find_if(tails.begin(), tails.end(),
                                 [&](const Tail& each) { return gap.port && each.coil == gap.coil; });
  if (tail == tails.end()) return std::nullopt;
  return cover.at(tail->pads[0]) >= 0 || cover.at(tail->pads[1]) >= 0;
}

// Whether most of a pad is covered: lengths along the loop in the drawing, its width on the part.
bool is_covered(const Trace& trace, const Interval& pad, double width_mm, const Islands& cover) {
  constexpr int along = 6, across = 3;
  int covered = 0, places = 0;
  for (int i = 0; i < along; ++i)
    for (int k = 0; k < across; ++k)
      if (const auto at = trace.rest(pad.from + pad.length() * (i + 0.5) / along,
                                     width_mm * ((k + 0.5) / across - 0.5))) {
        ++places;
        covered += cover.at(*at) >= 0;
      }
  return 2 * covered > places;
}

Warning about_gaps(const Drawing& drawing, const std::vector<const LoopGap*>& gaps) {
  constexpr std::size_t most_named = 12;
  Warning out{.code = "pads-covered",
              .text = std::to_string(gaps.size()) + (gaps.size() == 1 ? " gap has" : " gaps have") +
                      " resist or a picture over the pads, where no solder takes"};
  for (const LoopGap* gap : gaps)
    if (out.marks.size() < Warning::most_marks)
      out.marks.push_back({{gap->place.x(), gap->place.y(), gap->place.z()}, 5});
  for (std::size_t i = 0; i < std::min(gaps.size(), most_named); ++i)
    out.place += (i > 0 ? ", " : "") + drawing.elements[index(gaps[i]->coil)].id + " gap " +
                 std::to_string(gaps[i]->number);
  if (gaps.size() > most_named) out.place += " and " + std::to_string(gaps.size() - most_named) + " more";
  out.figure = Warning::Figure{static_cast<double>(gaps.size()), "gaps", 0.0};
  return out;
}

}  // namespace

std::optional<Warning> covered_pads(const Drawing& drawing, const Placement& placement,
                                    const ArrayBuild& build, const std::vector<PrintedInk>& ink,
                                    const CoilSettings& settings) {
  const std::array<Islands, 2> covers{cover_of(ink, 0), cover_of(ink, 1)};
  const double pad_mm = pads_of(settings).length;
  std::vector<const LoopGap*> found;
  std::unique_ptr<Trace> trace;
  int traced = -1;
  for (const LoopGap& gap : build.gaps) {
    const int face = build.faces[index(gap.coil)];
    const Islands& cover = covers[index(face)];
    if (gap.plate || cover.count() == 0) continue;
    if (const auto covered = has_covered_tail(build.tails, gap, cover)) {
      if (*covered) found.push_back(&gap);
      continue;
    }
    if (std::exchange(traced, gap.coil) != gap.coil) {
      const std::vector<PlacedElement>& elements = build.placement(face, placement).elements;
      const auto placed = std::find_if(elements.begin(), elements.end(),
                                       [&](const PlacedElement& each) { return each.element == gap.coil; });
      const DrawnLoop& loop = *drawing.elements[index(gap.coil)].loop;
      trace = std::make_unique<Trace>(loop, placed->patch, loop.width_mm * placed->size, placed->size);
    }
    const double length = pad_mm / trace->scale();
    if (is_covered(*trace, {gap.along.from - length, gap.along.from}, trace->width_mm(), cover) ||
        is_covered(*trace, {gap.along.to, gap.along.to + length}, trace->width_mm(), cover))
      found.push_back(&gap);
  }
  if (found.empty()) return std::nullopt;
  return about_gaps(drawing, found);
}

}  // namespace vacuform
