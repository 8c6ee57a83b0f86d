// What the captions of previews say about coils and ink, as text. Pure functions of the figures. Internal to
// worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/coil_figures.hpp"

namespace vacuform {

// "6 of 19 coils on the head: out of round by 0.10 % on average, 0.20 % at worst     area off by 0.05 % on average". If
// one of the coils on the head is not drawn as a circle, says how far they are off their drawn shape instead. Without a
// coil on the head, only the count. Figures are those of one way of printing; the table has at least one coil.
std::string coils_caption(const CoilTable& table, Way way);

// What was found in a drawing: "7 coils and 2 other figures were found; 3.1 mm² of ink belong to none."
std::string found_caption(int coils, int figures, double loose_mm2);

// Where the drawing's ink goes: `printed` and `on_head` are shares of it in [0, 1], on_head at most printed. A share of
// 99.95 % or more counts as all.
std::string ink_caption(double printed, double on_head);

// Where the colours of the scan go: `faded` is the share of the coloured area that is not on the scan.
std::string colours_caption(double faded);

}  // namespace vacuform
