// Titles and legends on previews. Internal to worker/inspection.
#pragma once

#include <optional>
#include <string>

#include "worker/inspection/view.hpp"

namespace vacuform {

// Viridis (S. van der Walt, N. Smith 2015): even steps look even, also without colour vision and in gray.
// `fraction` is clamped to [0, 1].
Rgb viridis(double fraction);

struct Scale {
  double low, high, step;   // ticks at low, low + step, ..., high
  std::string quantity;     // what the bar shows, with its unit
  bool open_above = false;  // values above the end exist
};
// A scale over at least [low, high] with three to seven round ticks. A `fixed_low` end is not rounded.
Scale round_scale(double low, double high, bool fixed_low, std::string quantity);

struct Caption {
  std::string title, figures;  // one line each
  std::optional<Scale> scale;
  std::string note;  // one line in the scale's place
};

// Rows that a caption takes above and below the picture.
inline constexpr int caption_top = 104, caption_bottom = 92;
void write(const Caption& caption, Picture& picture);

}  // namespace vacuform
