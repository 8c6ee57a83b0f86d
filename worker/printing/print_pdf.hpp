// print.pdf: the print at 1:1. Internal to worker/printing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/printing/output_profile.hpp"
#include "worker/printing/print_svg.hpp"

namespace vacuform {

// Refers to what the files of a layer are made of.
struct PdfPage {
  std::string name;
  PrintPage page;
  PageContent shown;
};

// Pages of the size of the sheet, with two layers that a viewer can switch, "pattern" and "marks". Of several pages, a viewer
// shows the name of each as its label. Vectors stay vectors; a picture is embedded losslessly with its own deflated rows. Texts
// are texts, in Helvetica, which every viewer and press has. A picture with an opacity is converted to `profile`. Colours of
// vectors are sRGB. No dates: the same print gives the same bytes.
std::vector<std::uint8_t> make_pdf(const std::vector<const PdfPage*>& pages, const OutputProfile& profile);

}  // namespace vacuform
