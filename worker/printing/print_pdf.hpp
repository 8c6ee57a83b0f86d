// print.pdf: the print at 1:1. Internal to worker/printing.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/printing/output_profile.hpp"
#include "worker/printing/print_svg.hpp"

namespace vacuform {

// One page of the size of the sheet, with two layers that a viewer can switch, "pattern" and "marks". Vectors stay
// vectors; a picture is embedded losslessly with its own deflated rows. Texts are texts, in Helvetica, which every
// viewer and press has. A picture with an opacity is converted to `profile`. Colours of vectors are sRGB. No dates: the same print gives the same bytes.
std::vector<std::uint8_t> make_pdf(const PrintPage& page, const PageContent& shown,
                                   const OutputProfile& profile);

}  // namespace vacuform
