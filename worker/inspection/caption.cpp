#include "worker/inspection/caption.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/inspection/canvas.hpp"

namespace vacuform {
void write(const Caption& caption, Picture& picture) {
  Canvas canvas(picture);
  cairo_t* cairo = canvas.cairo();
  canvas.band(0, caption_top, caption_top - 1);
  const double room = picture.width - 80;
  canvas.text(caption.title, 40, 50, 27, true, 0, 0.13f, room);
  canvas.text(caption.figures, 40, 82, 17, false, 0, 0.32f, room);
  canvas.band(picture.height - caption_bottom, picture.height, picture.height - caption_bottom);
  if (!caption.scale) {
    canvas.text(caption.note, 40, picture.height - 40, 17, false, 0, 0.2f, room);
  } else {
    const HeatMap& map = *caption.scale;
    const double left = 40, right = picture.width - 40.0, top = picture.height - 55.0, thick = 18;
    const auto across = [&](double value) {
      return left + (right - left) * (value - map.low) / (map.high - map.low);
    };
    for (int x = static_cast<int>(left); x < static_cast<int>(right); ++x) {
      canvas.colour(map.colour(map.low + (map.high - map.low) * (x + 0.5 - left) / (right - left)));
      cairo_rectangle(cairo, x, top, 1, thick);
      cairo_fill(cairo);
    }
    canvas.text(std::string(map.title()) + (map.unit.empty() ? "" : ", " + std::string(map.unit)), left,
                top - 10, 17, false, 0, 0.2f, room);
    bool below = false, above = false;
    for (const double value : map.values) below = below || value < map.low, above = above || value > map.high;
    // As many digits as the step needs: two for 0.25, one for 0.2.
    int places = 0;
    for (double step = map.step; places < 6 && std::abs(step - std::round(step)) > 1e-6; step *= 10) ++places;
    const int first = static_cast<int>(std::ceil(map.low / map.step - 1e-6)),
              last = static_cast<int>(std::floor(map.high / map.step + 1e-6));
    for (int i = first; i <= last; ++i) {
      const double x = across(i * map.step);
      cairo_set_source_rgb(cairo, 0.25, 0.25, 0.27);
      cairo_rectangle(cairo, std::clamp(std::round(x), left, right - 1), top + thick, 1, 6);
      cairo_fill(cairo);
      const std::string beyond = i == last && above ? "≥ " : i == first && below ? "≤ " : "";
      canvas.text(beyond + decimal(map.step * i, places), x, top + thick + 24, 17, false,
                  x < left + 20    ? 0
                  : x > right - 20 ? 1
                                   : 0.5,
                  0.2f);
    }
  }
}

}  // namespace vacuform
