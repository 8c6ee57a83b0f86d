// The files of a layer: its ink with the marks, as PNG, SVG and PDF. Internal to worker/printing.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "worker/printing/layer.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/output_profile.hpp"
#include "worker/printing/print_pdf.hpp"

namespace vacuform {

// What the files of all layers of a print share.
struct PrintFormat {
  const Settings& settings;
  PrintGrid grid;
  PrintLabel label;  // as printable() gives it
  const OutputProfile& profile;
};

// The files of a layer, and what its page in a PDF is made of.
class PrintedLayer {
 public:
  // Memory is that of the files plus a band of rows. Reports the progress of the printing stage from 0 to 1. Errors:
  // cancelled.
  static Result<PrintedLayer> make(const Layer& layer, const Marks& marks, const PrintFormat& format,
                                   const Context& context);

  std::vector<std::uint8_t> png;
  std::string svg;
  PdfPage page;

 private:
  explicit PrintedLayer(PdfPage of) : page(std::move(of)) {}
  std::vector<std::uint8_t> whole_, colour_, opacity_;  // the picture of the page, as PNG
};

}  // namespace vacuform
