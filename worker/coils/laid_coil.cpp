#include "worker/coils/laid_coil.hpp"

#include <cmath>

#include "worker/coils/inductance.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

std::vector<LaidCoil> with_inductances(const ElementLayout& layout, std::vector<ElementOnSurface> laid) {
  std::vector<LaidCoil> out(laid.size());
  in_parallel(0, static_cast<int>(laid.size()), [&](int first, int last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
      const LaidElement& of = layout.elements[i];
      out[i].element = std::move(laid[i]);
      if (const auto& loop = out[i].element.loop; !loop.empty())
        out[i].self_nh = self_inductance_nh(loop, of.size * of.outline.width_mm);
    }
  });
  return out;
}

Result<std::vector<LaidCoil>> lay_coils(const ChartedSurface& charted, const ElementLayout& layout,
                                        const Context& context, bool rough) {
  VACUFORM_TRY(laid, lay_on_surface(charted, layout, context, rough));
  return with_inductances(layout, std::move(laid));
}

std::optional<double> coupling(const LaidCoil& a, const LaidCoil& b) {
  if (a.element.loop.empty() || b.element.loop.empty()) return {};
  return mutual_inductance_nh(a.element.loop, b.element.loop) / std::sqrt(a.self_nh * b.self_nh);
}

Result<CouplingMatrix> coupling_matrix(const std::vector<LaidCoil>& coils, const Context& context) {
  if (coils.size() > most_coupled_coils) return CouplingMatrix();
  std::vector<InductiveLoop> loops;
  for (const LaidCoil& coil : coils) loops.push_back({coil.element.loop, coil.self_nh});
  return coupling_matrix(loops, context);
}

}  // namespace vacuform
