// Titles and legends on previews. Internal to worker/inspection.
#pragma once

#include <optional>
#include <string>

#include "worker/inspection/view.hpp"

namespace vacuform {

// Viridis (S. van der Walt, N. Smith 2015): even steps look even, also without colour vision and in gray.
// `fraction` is clamped to [0, 1].
Colour viridis(double fraction);

struct Scale {
  double low, high;
  int places;           // digits behind the point on the ticks
  std::string quantity;  // what the bar shows, with its unit
  bool open_below = false, open_above = false;  // values beyond the ends exist
};

struct Caption {
  std::string title, figures;  // one line each
  std::optional<Scale> scale;
};

// Rows that a caption needs above and below the picture.
inline constexpr int caption_top = 96, caption_bottom = 96;
void write(const Caption& caption, Picture& picture);

}  // namespace vacuform
