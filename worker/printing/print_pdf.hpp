// print.pdf: the print at 1:1. Internal to worker/printing.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/printing/print_svg.hpp"

namespace vacuform {

// One page of the sheet's size, with two layers that a viewer can switch, "pattern" and "marks". The vectors stay vectors;
// a picture is embedded losslessly with its own deflated rows. Texts are texts, in Helvetica, which every viewer and
// press has. `alpha` is a gray PNG of the picture's opacity, empty where it has none; the picture is then RGB. No dates:
// the same bytes for the same print.
std::vector<std::uint8_t> make_pdf(const PrintPage& page, const VectorPrint* vectors,
                                   const PlacedPicture* picture, std::span<const std::uint8_t> alpha,
                                   const Marks& marks);

}  // namespace vacuform
