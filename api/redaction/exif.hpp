// What of the Exif data of a JPEG decides how the picture looks: which way up it is and how large (CIPA DC-008, 4.6.5). The
// redacted copy has this and nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vacuform {

struct Exif {
  // Pixels in a unit of length, as fractions of positive numbers.
  struct Density {
    std::array<std::uint32_t, 2> x{}, y{};
    double unit_mm = 25.4;  // or 10
    double pixel_width_mm() const { return unit_mm * x[1] / x[0]; }
    double pixel_height_mm() const { return unit_mm * y[1] / y[0]; }
  };
  int orientation = 1;             // 1 upright ... 8
  std::optional<Density> density;  // if it is given with a unit
};

// Of the first directory in the data of a segment APP1, whatever its bytes. Of another segment: nothing.
Exif read_exif(std::string_view segment);

// The data of a segment with this alone. Empty if there is nothing to say.
std::string exif_segment(const Exif& exif);

}  // namespace vacuform
