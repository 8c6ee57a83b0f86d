// Titles and legends on previews. Internal to worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/heat_maps.hpp"

namespace vacuform {

struct Caption {
  std::string title, figures;      // one line each
  const HeatMap* scale = nullptr;  // whose colours and values it shows below; else
  std::string note;                // one line
};

// Rows that a caption takes above and below the picture.
inline constexpr int caption_top = 104, caption_bottom = 92;
void write(const Caption& caption, Picture& picture);

}  // namespace vacuform
