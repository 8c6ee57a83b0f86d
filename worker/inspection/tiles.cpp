#include "worker/inspection/tiles.hpp"

#include <algorithm>

#include "worker/inspection/canvas.hpp"

namespace vacuform {

Tiles::Tiles(int count)
    : whole_{tile_columns * tile_width,
             caption_top + (count + tile_columns - 1) / tile_columns * tile_height + caption_bottom,
             {}},
      labels_(static_cast<std::size_t>(count)) {
  whole_.pixels.assign(static_cast<std::size_t>(whole_.width) * static_cast<std::size_t>(whole_.height),
                       0xffffffffu);
}

void Tiles::put(int index, const Picture& tile, std::string label) {
  const int left = index % tile_columns * tile_width, top = caption_top + index / tile_columns * tile_height;
  for (int y = tile_label; y < tile_height; ++y)
    std::copy_n(tile.pixels.begin() + static_cast<std::ptrdiff_t>(y) * tile_width, tile_width,
                whole_.pixels.begin() + static_cast<std::ptrdiff_t>(top + y) * whole_.width + left);
  labels_[index] = std::move(label);
}

Picture Tiles::finished(const Caption& caption) {
  write(caption, whole_);
  {
    Canvas canvas(whole_);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      const int column = static_cast<int>(i) % tile_columns, row = static_cast<int>(i) / tile_columns;
      canvas.text(labels_[i], column * tile_width + 14, caption_top + row * tile_height + 23, 18, true, 0,
                  0.2f, tile_width - 28);
    }
  }
  return std::move(whole_);
}

}  // namespace vacuform
