#include "worker/studies/coil_centres.hpp"

#include "worker/pattern/drawing.hpp"
#include "worker/pattern/ink_parts.hpp"

namespace vacuform {

std::vector<CoilCentre> coil_centres(const Pattern& pattern) {
  std::vector<CoilCentre> centres;
  const auto take = [&](const Drawing& drawing) {
    for (const Element& element : drawing.elements)
      if (!element.id.empty()) centres.push_back({element.id, element.centre});
  };
  std::vector<Warning> known;  // the printing stage gives them
  if (const auto drawing = read_drawing(pattern, known)) take(*drawing);
  if (centres.empty()) take(InkParts(pattern).drawing());
  return centres;
}

}  // namespace vacuform
