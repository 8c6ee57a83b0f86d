#include "worker/inspection/caption_words.hpp"

#include "api/base/decimal.hpp"

namespace vacuform {

std::string coils_caption(const CoilTable& table, Way way) {
  const CoilSummary& c = table[way];
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

std::string found_caption(int coils, int figures, double loose_mm2) {
  const auto counted = [](int n, const char* one, const char* several) {
    return (n == 0 ? std::string("no") : std::to_string(n)) + (n == 1 ? one : several);
  };
  std::string out = counted(coils, " coil", " coils");
  if (figures > 0) out += " and " + counted(figures, " other figure", " other figures");
  out += coils + figures == 1 ? " was found" : " were found";
  out[0] = out[0] == 'n' ? 'N' : out[0];
  if (loose_mm2 >= 0.05) out += "; " + decimal(loose_mm2, 1) + " mm² of ink belong to none";
  return out + ".";
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
