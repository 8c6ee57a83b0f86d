#include "worker/inspection/caption_words.hpp"

#include "api/base/decimal.hpp"

namespace vacuform {

std::string coils_caption(const CoilTable& table, CoilSummary CoilTable::*way) {
  const CoilSummary& c = table.*way;
  const std::size_t all = table.coils.size();
  const std::string counted = std::to_string(c.coils) + " of " + std::to_string(all) +
                              (all == 1 ? " coil" : " coils") + " on the head";
  if (c.coils == 0) return counted;
  const bool round = c.round == c.coils;
  return counted + (round ? ": out of round by " : ": off their drawn shape by ") +
         in_percent(round ? c.mean_circularity : c.mean_shape_error, 2) + " on average, " +
         in_percent(round ? c.worst_circularity : c.worst_shape_error, 2) + " at worst     area off by " +
         in_percent(c.mean_area_error, 2) + " on average";
}

std::string ink_caption(double printed, double on_head) {
  constexpr double all = 0.9995;
  if (printed < all)
    return in_percent(1 - printed, 1) +
           " of the drawing's ink lies off the formed part and is not printed; " + in_percent(on_head, 1) +
           " lies on the head.";
  if (on_head < all)
    return "All of the drawing's ink is printed; " + in_percent(on_head, 1) +
           " of it lies on the head, the rest beside it.";
  return "All of the drawing's ink lies on the head.";
}

std::string colours_caption(double faded) {
  constexpr double none = 0.0005;
  if (faded < none) return "The coloured area touches the scan everywhere.";
  return in_percent(1 - faded, 1) + " of the coloured area touches the scan; on the rest the colours fade.";
}

}  // namespace vacuform
