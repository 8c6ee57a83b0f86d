// Ink on the flat sheet as rows of pixels, made band by band. Internal to worker/printing and worker/inspection.
#pragma once

#include <cstdint>
#include <vector>

namespace vacuform {

// Pixels over the whole sheet. Their centre is the centre of the sheet.
struct PrintGrid {
  int width = 0, height = 0;  // pixels
  double pixel_mm = 0;
};

struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;  // half open
};

class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual PixelBox box() const = 0;   // around all ink, never empty; pixels before any mirroring
  virtual int band_rows() const = 0;  // rows to ask for at once
  virtual int channels() const = 0;   // 1: 8-bit gray on white; 4: straight RGBA on transparent
  // Rows [top, bottom) of the grid's whole width. `top` is a multiple of band_rows(), and `bottom` at most one band
  // further.
  virtual std::vector<std::uint8_t> rows(int top, int bottom) const = 0;
};

}  // namespace vacuform
