// The inked part of a print as rows of pixels, made band by band. Internal to worker/printing.
#pragma once

#include <cstdint>
#include <vector>

namespace vacuform {

struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;  // half open
};

class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual PixelBox box() const = 0;   // around all ink, never empty; pixels before any mirroring
  virtual int band_rows() const = 0;  // rows to ask for at once
  // Rows [top, bottom) of the whole print's width: 8-bit gray on white, or straight RGBA on transparent. `top` is a
  // multiple of band_rows(), and `bottom` at most one band further.
  virtual std::vector<std::uint8_t> rows(int top, int bottom) const = 0;
};

}  // namespace vacuform
