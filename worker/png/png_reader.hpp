// Reads the rows of an untrusted PNG with libpng, within limits; data that no picture needs is never unpacked.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

struct png_struct_def;
struct png_info_def;

namespace vacuform {

class PngReader {
 public:
  enum class Rows { rgba8, gray16 };  // 8-bit RGBA of any PNG; 16-bit gray, high byte first, of a gray one

  explicit PngReader(std::span<const std::uint8_t> bytes);
  ~PngReader();
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // Call these in this order. Each returns false if the file is damaged, and message() says how.
  bool begin(Rows rows);           // up to the first row
  bool row(std::uint8_t* pixels);  // the next; all rows once for every pass
  bool end();

  int passes() const { return passes_; }
  int bits_per_pixel() const { return bits_per_pixel_; }  // in the file
  std::size_t row_bytes() const;                          // of what row() writes
  const char* message() const { return message_; }

  struct PixelSize {
    double width_mm, height_mm;
  };
  std::optional<PixelSize> pixel_size() const;  // of the pHYs chunk, if it has a unit

 private:
  [[noreturn]] static void on_error(png_struct_def* png, const char* message);
  static void on_read(png_struct_def* png, unsigned char* out, std::size_t count);

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  png_struct_def* png_ = nullptr;
  png_info_def* info_ = nullptr;
  int passes_ = 1, bits_per_pixel_ = 8;
  char message_[96] = {};
};

}  // namespace vacuform
