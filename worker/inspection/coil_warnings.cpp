#include "worker/inspection/coil_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

constexpr double most_shape_error = 0.005, most_spacing_mm = 2;

// "coil-1, coil-2 and 5 more"
std::string names(const std::vector<const Coil*>& coils) {
  constexpr std::size_t most = 8;
  std::string out;
  for (std::size_t i = 0; i < coils.size(); ++i) {
    if (i == most) return out + " and " + std::to_string(coils.size() - most) + " more";
    if (i > 0) out += i + 1 == coils.size() ? " and " : ", ";
    out += coils[i]->id;
  }
  return out;
}

Warning out_of_shape(const std::vector<const Coil*>& worst_first, int on_head) {
  const Coil& worst = *worst_first.front();
  const double error = worst.with->shape_error;
  const auto bumpy =
      std::count_if(worst_first.begin(), worst_first.end(), [](const Coil* c) { return !c->smooth; });
  Warning warning{"coil-out-of-shape",
                  std::to_string(worst_first.size()) + " of " + std::to_string(on_head) +
                      " coils on the head come out farther from their drawn shape than " +
                      in_percent(most_shape_error, 1) + " of their size; the worst, " + worst.id + ", by " +
                      decimal(worst.with->shape.largest_mm, 2) + " mm (" + in_percent(error, 1) + ")"};
  if (bumpy > 0) warning.text += "; " + std::to_string(bumpy) + " of them lie on bumps";
  warning.figure = Warning::Figure{100 * error, "%", 100 * most_shape_error};
  warning.place = names(worst_first);
  for (std::size_t i = 0; i < std::min(worst_first.size(), Warning::most_marks); ++i) {
    const CoilFigures& f = *worst_first[i]->with;
    warning.marks.push_back({{f.centre.x(), f.centre.y(), f.centre.z()}, f.diameter_mm});
  }
  return warning;
}

std::vector<CoupledLoops> coupled_on_head(const CoilTable& table) {
  std::vector<ArrayLoop> loops;
  for (const Coil& coil : table.coils)
    loops.push_back({coil.id, coil.with ? coil.with->centre : Eigen::Vector3d::Zero(), coil.radius_mm(),
                     coil.with && coil.with->on_head});
  std::vector<NeighbourLoop> neighbours;
  for (const CoilPair& pair : table.pairs)
    neighbours.push_back(
        {pair.a, pair.b, pair.with ? pair.with->k : std::nullopt, pair.with ? pair.with->mm : 0});
  return coupled_loops(loops, neighbours, table.k.with);
}

}  // namespace

std::vector<Warning> coil_warnings(const CoilTable& table, bool decoupled) {
  std::vector<Warning> warnings;
  std::vector<const Coil*> off;
  for (const Coil& coil : table.coils)
    if (coil.with && coil.with->on_head && coil.with->shape_error > most_shape_error) off.push_back(&coil);
  std::stable_sort(off.begin(), off.end(),
                   [](const Coil* a, const Coil* b) { return a->with->shape_error > b->with->shape_error; });
  if (!off.empty()) warnings.push_back(out_of_shape(off, table.with.coils));

  if (!decoupled && table.with.pairs > 0 && table.with.spacing_rms_mm > most_spacing_mm)
    warnings.push_back(
        {.code = "coils-spacing",
         .text = "The distances of neighbouring coils on the head differ from the drawing by " +
                 decimal(table.with.spacing_rms_mm, 1) + " mm RMS, at worst by " +
                 decimal(table.with.worst_spacing_mm, 1) +
                 " mm: the surface is too curved to meet all drawn distances at once",
         .figure = Warning::Figure{table.with.spacing_rms_mm, "mm", most_spacing_mm},
         .place = std::to_string(table.with.pairs) + " pairs of neighbours on the head"});

  if (auto warning = coupling_warning(coupled_on_head(table), decoupled))
    warnings.push_back(std::move(*warning));
  return warnings;
}

}  // namespace vacuform
