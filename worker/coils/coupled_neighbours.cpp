#include "worker/coils/coupled_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

// Decoupling may lead an array away from where the user laid it. A coil's moved_mm in the report counts from the chart.
std::optional<Warning> moved_far(const Drawing& drawing, const ElementLayout& layout,
                                 const std::vector<Centre>& before) {
  constexpr double far_mm = 10;
  std::size_t worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (const double mm = (layout.centres[i].moved - before[i].moved).norm(); mm > most) most = mm, worst = i;
  if (most <= far_mm) return std::nullopt;
  const std::string& id = drawing.elements[index(layout.elements[worst].element)].id;
  return Warning{.code = "coils-moved",
                 .text = "Decoupling moved " + id + " by " + decimal(most, 0) +
                         " mm, and no coil farther; it lies " +
                         decimal(layout.centres[worst].moved.norm(), 1) + " mm from where the chart puts it.",
                 .figure = Warning::Figure{most, "mm", far_mm},
                 .place = id};
}

std::optional<Warning> not_decoupled(const std::vector<LaidCoil>& coils) {
  const auto loops = static_cast<std::size_t>(
      std::count_if(coils.begin(), coils.end(), [](const LaidCoil& coil) { return coil.self_nh > 0; }));
  if (loops <= most_coupled_coils) return std::nullopt;
  return Warning{.code = "coils-not-decoupled",
                 .text = "The drawing has " + std::to_string(loops) +
                         " loops on the sheet, and decoupling takes at most " +
                         std::to_string(most_coupled_coils) + ": none of them was moved or resized",
                 .figure = Warning::Figure{static_cast<double>(loops), "loops", most_coupled_coils}};
}

}  // namespace

Result<void> add_couplings(const ChartedSurface& charted, const Drawing& drawing, const Settings& settings,
                           const Context& context, Placement& placement) {
  if (placement.elements.empty()) return {};
  std::vector<LaidCoil> coils = with_inductances(placement.layout, placement.laid);
  const auto couplings = [&](std::optional<double> PlacedPair::*k) {
    for (PlacedPair& p : placement.pairs) p.*k = coupling(coils[p.a], coils[p.b]);
  };
  couplings(&PlacedPair::k_before);
  if (settings.coils.decouple) {
    ElementLayout layout = placement.layout;
    VACUFORM_CHECK(decouple(charted, layout, coils, settings.coils.size_limit, context));
    couplings(&PlacedPair::k);
    auto moved = moved_far(drawing, layout, placement.layout.centres);
    auto too_many = not_decoupled(coils);
    std::vector<ElementOnSurface> laid;
    for (LaidCoil& coil : coils) laid.push_back(std::move(coil.element));
    take_layout(charted.surface(), drawing, settings.pattern.scale, std::move(layout), std::move(laid),
                placement);
    for (auto* warning : {&moved, &too_many})
      if (*warning) placement.warnings.insert(placement.warnings.begin(), *std::move(*warning));
    return {};
  }
  couplings(&PlacedPair::k);
  return {};
}

std::vector<CoupledLoops> coupled_loops(const std::vector<ArrayLoop>& loops,
                                        const std::vector<NeighbourLoop>& neighbours,
                                        const CouplingMatrix& matrix) {
  std::vector<CoupledLoops> out;
  std::set<std::pair<int, int>> known;
  const auto add = [&](const ArrayLoop& a, const ArrayLoop& b, double k, double mm, bool are_neighbours) {
    const bool overlap = (a.centre - b.centre).norm() < overlap_share * (a.radius_mm + b.radius_mm);
    if (a.on_head && b.on_head)
      out.push_back({a.id, b.id, k, mm, (a.centre + b.centre) / 2, are_neighbours, overlap});
  };
  for (const NeighbourLoop& pair : neighbours) {
    known.insert(std::minmax(pair.a, pair.b));
    if (pair.k) add(loops[index(pair.a)], loops[index(pair.b)], *pair.k, pair.mm, true);
  }
  for (int i = 0; i < matrix.count(); ++i)
    for (int j = i + 1; j < matrix.count(); ++j) {
      if (!(std::abs(matrix(i, j)) >= neighbours_k) || known.contains({i, j})) continue;
      const ArrayLoop &a = loops[index(i)], &b = loops[index(j)];
      add(a, b, matrix(i, j), (a.centre - b.centre).norm(), false);
    }
  return out;
}

Result<std::vector<CoupledLoops>> coupled_loops(const Placement& placement, const Drawing& drawing,
                                                const Context& context) {
  std::vector<ArrayLoop> loops;
  for (std::size_t i = 0; i < placement.elements.size(); ++i) {
    const PlacedElement& placed = placement.elements[i];
    const LaidElement& laid = placement.layout.elements[i];
    loops.push_back({drawing.elements[index(placed.element)].id, placed.centre,
                     laid.size * laid.outline.radius_mm, placed.on_head});
  }
  std::vector<NeighbourLoop> neighbours;
  for (const PlacedPair& pair : placement.pairs) neighbours.push_back({pair.a, pair.b, pair.k, pair.mm});
  VACUFORM_TRY(matrix, coupling_matrix(with_inductances(placement.layout, placement.laid), context));
  return coupled_loops(loops, neighbours, matrix);
}

std::optional<Warning> coupling_warning(const std::vector<CoupledLoops>& pairs, bool decoupled) {
  std::vector<CoupledLoops> strong;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(strong),
               [&](const CoupledLoops& p) { return std::abs(p.k) >= most_k(p, decoupled); });
  if (strong.empty()) return std::nullopt;
  std::stable_sort(strong.begin(), strong.end(), [](const CoupledLoops& p, const CoupledLoops& q) {
    return std::abs(p.k) > std::abs(q.k);
  });
  const CoupledLoops& worst = strong.front();
  const auto neighbours = [](const std::vector<CoupledLoops>& of) {
    return std::count_if(of.begin(), of.end(), [](const CoupledLoops& p) { return p.neighbours; });
  };
  const auto near = neighbours(strong), far = static_cast<std::ptrdiff_t>(strong.size()) - near;
  Warning warning{"coils-coupled", ""};
  const auto count = [](std::ptrdiff_t of, const char* what) {
    return std::to_string(of) + (of == 1 ? " pair" : " pairs") + what;
  };
  const std::string by_far = " by " + decimal(unnulled_k, 2) + " or more";
  if (near > 0)
    warning.text = std::to_string(near) + " of " +
                   count(neighbours(pairs), " of neighbours on the head couple by ") +
                   decimal(neighbours_k, 2) + " or more" +
                   (far > 0 ? ", and " + count(far, " of other coils") + by_far : std::string());
  else
    warning.text = count(far, " of coils on the head that are no neighbours couple") + by_far;
  if (decoupled) warning.text += ": the surface does not let them be decoupled within coils.size_limit";
  warning.text += "; the strongest, " + worst.a + " and " + worst.b + ", by k = " + decimal(worst.k, 3);
  if (!decoupled)
    warning.fix = "Set coils.decouple=true, or draw these coils closer together or farther apart.";
  warning.figure = Warning::Figure{std::abs(worst.k), "", most_k(worst, decoupled)};
  for (std::size_t i = 0; i < std::min(strong.size(), Warning::most_marks); ++i) {
    warning.place +=
        (i > 0 ? ", " : "") + strong[i].a + " and " + strong[i].b + " (k = " + decimal(strong[i].k, 3) + ")";
    warning.marks.push_back({{strong[i].place.x(), strong[i].place.y(), strong[i].place.z()}, strong[i].mm});
  }
  if (strong.size() > Warning::most_marks)
    warning.place += " and " + std::to_string(strong.size() - Warning::most_marks) + " more pairs";
  return warning;
}

}  // namespace vacuform
