#include "worker/png/png_reader.hpp"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <new>

namespace vacuform {

// libpng reports errors by longjmp; every method that calls it holds only trivial locals, so none is skipped.

PngReader::PngReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
  if (png_) info_ = png_create_info_struct(png_);
  if (!info_) {
    png_destroy_read_struct(&png_, nullptr, nullptr);
    throw std::bad_alloc();
  }
}

PngReader::~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

bool PngReader::begin(Rows rows) {
  if (setjmp(png_jmpbuf(png_))) return false;
  png_set_read_fn(png_, this, on_read);
  png_set_user_limits(png_, 1'000'000, 1'000'000);
  png_set_chunk_malloc_max(png_, 4 << 20);
  png_set_chunk_cache_max(png_, 64);
  // Compressed texts and profiles are not used, and can be decompression bombs.
  static const png_byte ignored[] = "iCCP\0zTXt\0iTXt\0tEXt\0sPLT\0eXIf";
  png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, ignored, 6);
  png_read_info(png_, info_);
  bits_per_pixel_ = png_get_bit_depth(png_, info_) * png_get_channels(png_, info_);
  if (rows == Rows::rgba8) {
    png_set_scale_16(png_);
    png_set_expand(png_);
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 0xff, PNG_FILLER_AFTER);
  } else {
    png_set_expand_16(png_);
    png_set_strip_alpha(png_);
  }
  passes_ = png_set_interlace_handling(png_);
  png_read_update_info(png_, info_);
  return true;
}

bool PngReader::row(std::uint8_t* pixels) {
  if (setjmp(png_jmpbuf(png_))) return false;
  png_read_row(png_, pixels, nullptr);
  return true;
}

bool PngReader::end() {
  if (setjmp(png_jmpbuf(png_))) return false;
  png_read_end(png_, nullptr);
  return true;
}

std::size_t PngReader::row_bytes() const { return png_get_rowbytes(png_, info_); }

std::optional<PngReader::PixelSize> PngReader::pixel_size() const {
  png_uint_32 x = 0, y = 0;
  int unit = PNG_RESOLUTION_UNKNOWN;
  if (!png_get_pHYs(png_, info_, &x, &y, &unit) || unit != PNG_RESOLUTION_METER || x == 0 || y == 0)
    return std::nullopt;
  return PixelSize{1000.0 / x, 1000.0 / y};
}

void PngReader::on_error(png_struct_def* png, const char* message) {
  auto* self = static_cast<PngReader*>(png_get_error_ptr(png));
  std::strncpy(self->message_, message, sizeof self->message_ - 1);
  png_longjmp(png, 1);
}

void PngReader::on_read(png_struct_def* png, unsigned char* out, std::size_t count) {
  auto* self = static_cast<PngReader*>(png_get_io_ptr(png));
  if (count > self->bytes_.size() - self->position_) png_error(png, "the file ends early");
  std::memcpy(out, self->bytes_.data() + self->position_, count);
  self->position_ += count;
}

}  // namespace vacuform
