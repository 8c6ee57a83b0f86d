#include "worker/inspection/circuits_json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "worker/electrical/tuning.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/array_files.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

// Of the tail of a loop; null without one.
Json tail_json(const Finished& job, int element) {
  const auto tail = std::find_if(job.build->tails.begin(), job.build->tails.end(),
                                 [&](const Tail& each) { return each.coil == element; });
  if (tail == job.build->tails.end()) return nullptr;
  Json crossings = Json::array();
  for (const TailCrossing& crossing : tail->crossings)
    crossings.push_back(
        {{"under", job.placed->elements[index(crossing.under)].id}, {"place_mm", array(crossing.place, 1)}});
  const double omega = angular_frequency(job.settings.circuit.frequency_mhz);
  return {{"number", tail->number},
          {"length_mm", rounded(tail->length_mm, 1)},
          {"width_mm", rounded(tail->width_mm, 2)},
          {"between_mm", rounded(tail->between_mm, 2)},
          {"ohm", rounded(tail_ohm(*tail, job.settings.circuit), 3)},
          {"inductance_nh", rounded(tail->inductance_nh, 1)},
          {"reactance_ohm", rounded(omega * tail->inductance_nh * 1e-9, 1)},
          {"most_stretch", rounded(tail->most_stretch, 3)},
          {"pads_mm", array(tail->place, 1)},
          {"crossings", std::move(crossings)}};
}

}  // namespace

Json circuits_json(const Finished& job) {
  if (!job.figures.circuits || !job.build) return nullptr;
  const ElectricalCheck& check = *job.figures.circuits;
  const auto id = [&](int element) { return job.placed->elements[index(element)].id; };
  const auto places = [&](const std::vector<ElectricalCheck::Place>& all, bool with_mm) {
    Json out = Json::array();
    for (const ElectricalCheck::Place& each : all) {
      Json coils = {id(each.a)};
      if (each.b != each.a) coils.push_back(id(each.b));
      Json& one = out.emplace_back(Json{{"coils", std::move(coils)}, {"place_mm", array(each.at, 1)}});
      if (with_mm) one["distance_mm"] = rounded(each.mm, 2);
    }
    return out;
  };
  Json coils = Json::array(), bridges = Json::array();
  for (const PlacedElement& placed : job.placement.elements) {
    if (!job.placed->elements[index(placed.element)].loop) continue;
    Json gaps = Json::array();
    for (const LoopGap& gap : job.build->gaps)
      if (gap.coil == placed.element)
        gaps.push_back({{"number", gap.number},
                        {"port", gap.port},
                        {"drawn", gap.drawn},
                        {"place_mm", array(gap.place, 1)}});
    const InkedFace face = job.settings.pattern.inked_face;
    coils.push_back({{"id", id(placed.element)},
                     {"widest", job.build->widened.empty()
                                    ? Json()
                                    : Json(rounded(job.build->widened[index(placed.element)].widest, 2))},
                     {"face", name(job.build->faces[index(placed.element)] == 0 ? face : other_face(face))},
                     {"gaps", std::move(gaps)},
                     {"tail", tail_json(job, placed.element)}});
  }
  for (const Bridge& bridge : job.build->bridges)
    bridges.push_back({{"over", id(bridge.over())},
                       {"under", id(bridge.under())},
                       {"place_mm", array(bridge.crossing.place, 1)}});
  return {{"loops", check.loops},
          {"nets", check.nets},
          {"shorts", places(check.shorts, false)},
          {"opens", places(check.opens, false)},
          {"close", places(check.close, true)},
          {"coils", std::move(coils)},
          {"bridges", std::move(bridges)},
          {"electrical", job.figures.electrical ? electrical_json(job) : Json()}};
}

}  // namespace vacuform
