#include "worker/coils/coupled_neighbours.hpp"

#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/coils/decoupling.hpp"

namespace vacuform {

namespace {

// Decoupling may lead an array away from where the user laid it.
void say_how_far(const Drawing& drawing, const ElementLayout& layout, const std::vector<Centre>& before,
                 std::vector<Warning>& warnings) {
  constexpr double far_mm = 10;
  std::size_t worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (const double mm = (layout.centres[i].moved - before[i].moved).norm(); mm > most) most = mm, worst = i;
  if (most > far_mm)
    warnings.push_back(
        {.code = "coils-moved",
         .text = "Decoupling moved the coils by up to " + decimal(most, 0) + " mm.",
         .figure = Warning::Figure{most, "mm", far_mm},
         .place = drawing.elements[static_cast<std::size_t>(layout.elements[worst].element)].id});
}

}  // namespace

Result<void> add_couplings(const ChartedSurface& charted, const Drawing& drawing, const Settings& settings,
                           const Context& context, Placement& placement) {
  if (placement.elements.empty()) return {};
  std::vector<LaidCoil> coils = with_inductances(placement.layout, placement.laid);
  const auto couplings = [&](std::optional<double> PlacedPair::*k) {
    for (PlacedPair& p : placement.pairs)
      p.*k = coupling(coils[static_cast<std::size_t>(p.a)], coils[static_cast<std::size_t>(p.b)]);
  };
  couplings(&PlacedPair::k_before);
  if (settings.coils.decouple) {
    ElementLayout layout = placement.layout;
    VACUFORM_CHECK(decouple(charted, layout, coils, settings.coils.size_limit, context));
    couplings(&PlacedPair::k);
    std::vector<Warning> moved;
    say_how_far(drawing, layout, placement.layout.centres, moved);
    std::vector<ElementOnSurface> laid;
    for (LaidCoil& coil : coils) laid.push_back(std::move(coil.element));
    take_layout(charted.surface(), drawing, settings.pattern.scale, std::move(layout), std::move(laid),
                placement);
    placement.warnings.insert(placement.warnings.begin(), moved.begin(), moved.end());
    return {};
  }
  couplings(&PlacedPair::k);
  return {};
}

std::vector<CoupledNeighbours> coupled_neighbours(const Placement& placement, const Drawing& drawing) {
  std::vector<CoupledNeighbours> out;
  for (const PlacedPair& pair : placement.pairs) {
    const auto element = [&](int i) -> const PlacedElement& {
      return placement.elements[static_cast<std::size_t>(i)];
    };
    const PlacedElement &a = element(pair.a), &b = element(pair.b);
    const auto id = [&](const PlacedElement& e) {
      return drawing.elements[static_cast<std::size_t>(e.element)].id;
    };
    if (pair.k && a.on_head && b.on_head)
      out.push_back({id(a), id(b), *pair.k, pair.mm, (a.centre + b.centre) / 2});
  }
  return out;
}

std::optional<Warning> coupling_warning(const std::vector<CoupledNeighbours>& pairs, bool decoupled) {
  constexpr double most_k = 0.01;
  std::vector<CoupledNeighbours> strong;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(strong),
               [](const CoupledNeighbours& p) { return std::abs(p.k) >= most_k; });
  if (strong.empty()) return std::nullopt;
  std::stable_sort(strong.begin(), strong.end(), [](const CoupledNeighbours& p, const CoupledNeighbours& q) {
    return std::abs(p.k) > std::abs(q.k);
  });
  const CoupledNeighbours& worst = strong.front();
  Warning warning{"coils-coupled", std::to_string(strong.size()) + " of " + std::to_string(pairs.size()) +
                                       " pairs of neighbours on the head couple by " + decimal(most_k, 2) +
                                       " or more"};
  if (decoupled) warning.text += ": the surface does not let them be decoupled within coils.size_limit";
  warning.text += "; the strongest, " + worst.a + " and " + worst.b + ", by k = " + decimal(worst.k, 3);
  if (!decoupled)
    warning.fix = "Set coils.decouple=true, or draw these coils closer together or farther apart.";
  warning.figure = Warning::Figure{std::abs(worst.k), "", most_k};
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
