#include "worker/inspection/circuits_json.hpp"

#include <nlohmann/json.hpp>

#include "worker/forming/inked_face.hpp"
#include "worker/inspection/array_files.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

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
                     {"gaps", std::move(gaps)}});
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
