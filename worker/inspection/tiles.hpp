// Several views in one preview: tiles in rows and columns below a common caption, each with a line of text above it.
// Internal to worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/caption.hpp"

namespace vacuform {

// Of a tile, with the rows that its text takes at its top.
inline constexpr int tile_columns = 2, tile_width = 500, tile_height = 400, tile_label = 34;

// The sides that a part is shown from.
inline constexpr View::Side five_sides[] = {View::Side::straight_front, View::Side::straight_back,
                                            View::Side::minus_x, View::Side::plus_x, View::Side::above};

class Tiles {
 public:
  explicit Tiles(int count);

  // `tile` is tile_width x tile_height, drawn below its first tile_label rows. Tiles fill the rows from the left.
  void put(int index, const Picture& tile, std::string label);
  Picture finished(const Caption& caption);

 private:
  Picture whole_;
  std::vector<std::string> labels_;
};

}  // namespace vacuform
