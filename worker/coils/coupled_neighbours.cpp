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
    const auto moved = moved_far(drawing, layout, placement.layout.centres);
    std::vector<ElementOnSurface> laid;
    for (LaidCoil& coil : coils) laid.push_back(std::move(coil.element));
    take_layout(charted.surface(), drawing, settings.pattern.scale, std::move(layout), std::move(laid),
                placement);
    if (moved) placement.warnings.insert(placement.warnings.begin(), *moved);
    return {};
  }
  couplings(&PlacedPair::k);
  return {};
}

std::vector<CoupledLoops> coupled_loops(const Placement& placement, const Drawing& drawing) {
  std::vector<CoupledLoops> out;
  std::set<std::pair<int, int>> known;
  const auto radius = [&](int i) {
    const LaidElement& e = placement.layout.elements[index(i)];
    return e.size * e.outline.radius_mm;
  };
  const auto add = [&](int i, int j, double k, double mm, bool neighbours) {
    const PlacedElement &a = placement.elements[index(i)], &b = placement.elements[index(j)];
    const auto id = [&](const PlacedElement& e) { return drawing.elements[index(e.element)].id; };
    const bool overlap = (a.centre - b.centre).norm() < overlap_share * (radius(i) + radius(j));
    if (a.on_head && b.on_head)
      out.push_back({id(a), id(b), k, mm, (a.centre + b.centre) / 2, neighbours, overlap});
  };
  for (const PlacedPair& pair : placement.pairs) {
    known.insert(std::minmax(pair.a, pair.b));
    if (pair.k) add(pair.a, pair.b, *pair.k, pair.mm, true);
  }
  const std::vector<LaidCoil> coils = with_inductances(placement.layout, placement.laid);
  for (int a = 0; a < static_cast<int>(coils.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(coils.size()); ++b) {
      if (known.contains({a, b})) continue;
      const double mm = (placement.elements[index(a)].centre - placement.elements[index(b)].centre).norm();
      if (const auto k = coupling(coils[index(a)], coils[index(b)]); k && std::abs(*k) >= unnulled_k)
        add(a, b, *k, mm, false);
    }
  return out;
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
