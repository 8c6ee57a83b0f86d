#include "worker/inspection/coil_json.hpp"

#include "worker/inspection/json_numbers.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

Json figures_json(const Coil& coil, const std::optional<CoilFigures>& figures) {
  if (!figures) return nullptr;
  const bool round = coil.round();
  return {{"on_head", figures->on_head},
          {"centre_mm", array(figures->centre, 2)},
          {"diameter_mm", rounded(figures->diameter_mm)},
          {"diameter_error", rounded(figures->diameter_error, 5)},
          {"circularity", round ? rounded(figures->circularity, 5) : Json(nullptr)},
          {"shape_error", rounded(figures->shape_error, 5)},
          {"shape_largest_mm", rounded(figures->shape.largest_mm, 3)},
          {"shape_mean_mm", rounded(figures->shape.mean_mm, 3)},
          {"area_mm2", rounded(figures->area_mm2, 3)},
          {"area_error", rounded(figures->area_error, 5)},
          {"worst_stretch", rounded(figures->worst_stretch)},
          {"inductance_nh", rounded(figures->inductance_nh, 2)}};
}

Json figures_json(const std::optional<PairFigures>& figures) {
  if (!figures) return nullptr;
  return {{"distance_mm", rounded(figures->mm)},
          {"overlap_mm", rounded(figures->overlap_mm)},
          {"k", rounded(figures->k, 5)}};
}

const std::string& id(const CoilTable& table, int coil) { return table.coils[coil].id; }

Json pair_json(const CoilTable& table, const std::optional<CoupledPair>& pair) {
  if (!pair) return nullptr;
  return {{"coils", {id(table, pair->a), id(table, pair->b)}},
          {"distance_mm", rounded(pair->mm)},
          {"k", rounded(pair->k, 5)}};
}

}  // namespace

Json coils_json(const CoilTable& table) {
  Json out = Json::array();
  for (const Coil& coil : table.coils)
    out.push_back({{"id", coil.id},
                   {"drawn_diameter_mm", rounded(coil.drawn_diameter_mm)},
                   {"drawn_area_mm2", rounded(coil.drawn_area_mm2, 3)},
                   {"drawn_circularity", rounded(coil.drawn_circularity, 5)},
                   {"size", rounded(coil.size, 5)},
                   {"moved_mm", rounded(coil.moved_mm, 3)},
                   {"with", figures_json(coil, coil.with)},
                   {"without", figures_json(coil, coil.without)}});
  return out;
}

Json pairs_json(const CoilTable& table) {
  Json out = Json::array();
  for (const CoilPair& pair : table.pairs)
    out.push_back({{"coils", {id(table, pair.a), id(table, pair.b)}},
                   {"drawn_distance_mm", rounded(pair.drawn_mm)},
                   {"drawn_overlap_mm", rounded(pair.drawn_overlap_mm)},
                   {"k_before_decoupling", rounded(pair.k_before, 5)},
                   {"with", figures_json(pair.with)},
                   {"without", figures_json(pair.without)}});
  return out;
}

Json summary_json(const CoilTable& table, Way way) {
  const CoilSummary& s = table[way];
  if (s.coils == 0) return nullptr;
  const bool pairs = s.pairs > 0;
  const Json none = nullptr;
  return {{"on_head", s.coils},
          {"round", s.round},
          {"mean_circularity", s.round > 0 ? rounded(s.mean_circularity, 5) : none},
          {"worst_circularity", s.round > 0 ? rounded(s.worst_circularity, 5) : none},
          {"mean_shape_error", rounded(s.mean_shape_error, 5)},
          {"worst_shape_error", rounded(s.worst_shape_error, 5)},
          {"mean_diameter_error", rounded(s.mean_diameter_error, 5)},
          {"worst_diameter_error", rounded(s.worst_diameter_error, 5)},
          {"mean_area_error", rounded(s.mean_area_error, 5)},
          {"worst_area_error", rounded(s.worst_area_error, 5)},
          {"pairs", s.pairs},
          {"spacing_rms_mm", pairs ? rounded(s.spacing_rms_mm) : none},
          {"worst_spacing_mm", pairs ? rounded(s.worst_spacing_mm) : none},
          {"worst_k", s.strongest_neighbours ? rounded(std::abs(s.strongest_neighbours->k), 5) : none},
          {"strongest_neighbours", pair_json(table, s.strongest_neighbours)},
          {"strongest_pair", pair_json(table, s.strongest)},
          {"keep", table.keep ? Json(name(*table.keep)) : none}};
}

Json couplings_json(const CoilTable& table) {
  std::vector<int> on_head;
  for (int i = 0; i < table.k.with.count(); ++i)
    if (const auto& with = table.coils[i].with; with && with->on_head) on_head.push_back(i);
  if (on_head.size() < 2) return nullptr;
  Json ids = Json::array(), rows = Json::array();
  for (const int a : on_head) {
    ids.push_back(id(table, a));
    Json row = Json::array();
    for (const int b : on_head) row.push_back(rounded(table.k.with(a, b), 5));
    rows.push_back(std::move(row));
  }
  return {{"coils", std::move(ids)}, {"k", std::move(rows)}};
}

Json traces_json(const TraceFigures& figures) {
  Json list = Json::array();
  for (const StretchedTrace& trace : figures.stretched)
    list.push_back({{"id", trace.id},
                    {"worst_stretch", rounded(trace.worst_stretch)},
                    {"worst_place_mm", array(trace.worst_place, 1)},
                    {"length_mm", rounded(trace.length_mm, 2)},
                    {"stretched_mm", rounded(trace.stretched_mm, 2)}});
  return {{"stretch_limit", rounded(figures.limit)},          {"traces", figures.traces},
          {"worst_stretch", rounded(figures.worst_stretch)},  {"length_mm", rounded(figures.length_mm, 2)},
          {"stretched_mm", rounded(figures.stretched_mm, 2)}, {"stretched", std::move(list)}};
}

}  // namespace vacuform
