// The files of a layer: its ink with the marks, as PNG, SVG and PDF. Internal to worker/printing.
#pragma once

#include "worker/printing/layer.hpp"
#include "worker/printing/marks.hpp"
#include "worker/printing/output_profile.hpp"

namespace vacuform {

// What the files of all layers of a print share.
struct PrintFormat {
  const Settings& settings;
  PrintGrid grid;
  PrintLabel label;  // as printable() gives it
  const OutputProfile& profile;
};

// Memory is that of the files plus a band of rows. Reports the progress of the printing stage from 0 to 1. Errors:
// cancelled.
Result<Layer::Files> layer_files(const Layer& layer, const Marks& marks, const PrintFormat& format,
                                 const Context& context);

}  // namespace vacuform
