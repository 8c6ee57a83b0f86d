#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

#include "worker/printing/raster.hpp"

namespace vacuform {
namespace {

// libpng reports errors by longjmp; every method that calls it holds only trivial locals, so none is skipped.
class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
    if (png_) info_ = png_create_info_struct(png_);
    if (!png_ || !info_) throw std::bad_alloc();
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // Reads up to the first row; all rows will be 8-bit RGBA.
  bool begin() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_read_fn(png_, this, on_read);
    png_set_user_limits(png_, 1'000'000, 1'000'000);
    png_set_chunk_malloc_max(png_, 4 << 20);
    png_set_chunk_cache_max(png_, 64);
    // Compressed texts and profiles say nothing that is printed and can be bombs.
    static const png_byte ignored[] = "iCCP\0zTXt\0iTXt\0tEXt\0sPLT\0eXIf";
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, ignored, 6);
    png_read_info(png_, info_);
    bits_per_pixel_ = png_get_bit_depth(png_, info_) * png_get_channels(png_, info_);
    png_set_scale_16(png_);
    png_set_expand(png_);
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 0xff, PNG_FILLER_AFTER);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  bool row(std::uint8_t* rgba) {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_row(png_, rgba, nullptr);
    return true;
  }

  bool end() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_end(png_, nullptr);
    return true;
  }

  int passes() const { return passes_; }
  int bits_per_pixel() const { return bits_per_pixel_; }
  const char* message() const { return message_; }
  bool ended_early() const { return ended_early_; }

  std::optional<Eigen::Vector2d> pixel_mm() const {
    png_uint_32 x = 0, y = 0;
    int unit = PNG_RESOLUTION_UNKNOWN;
    if (!png_get_pHYs(png_, info_, &x, &y, &unit) || unit != PNG_RESOLUTION_METER || x == 0 || y == 0)
      return std::nullopt;
    return Eigen::Vector2d(1000.0 / x, 1000.0 / y);
  }

 private:
  [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
    auto* self = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(self->message_, message, sizeof self->message_ - 1);
    png_longjmp(png, 1);
  }
  static void on_read(png_structp png, png_bytep out, std::size_t count) {
    auto* self = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > self->bytes_.size() - self->position_) {
      self->ended_early_ = true;
      png_error(png, "the file ends early");
    }
    std::memcpy(out, self->bytes_.data() + self->position_, count);
    self->position_ += count;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1, bits_per_pixel_ = 8;
  bool ended_early_ = false;
  char message_[96] = {};
};

void premultiply(std::vector<std::uint8_t>& row) {
  for (std::size_t i = 0; i < row.size(); i += 4) {
    const int a = row[i + 3];
    if (a != 255)
      for (std::size_t k = i; k < i + 3; ++k) row[k] = static_cast<std::uint8_t>((row[k] * a + 127) / 255);
  }
}

std::uint32_t big_endian(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}

}  // namespace

Result<Raster> read_png(std::span<const std::uint8_t> bytes, const std::string& file_name, int channels) {
  const auto corrupt = [&](const std::string& what) {
    return fail(Code::corrupt_file, "the PNG is damaged: " + what, file_name, "export the drawing again");
  };
  if (bytes.size() < 33) return corrupt("the file ends early");
  // Sizes first, from the header itself: libpng's own limits cannot tell a large picture from a damaged one.
  const std::int64_t width = big_endian(&bytes[16]), height = big_endian(&bytes[20]);
  if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return corrupt("it has no size");
  if (width > 1'000'000 || height > 1'000'000 || width * height > largest_raster)
    return fail(Code::too_large,
                "the drawing has " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                file_name, "give one of at most 64 million pixels, or an SVG");

  PngReader reader(bytes);
  if (!reader.begin()) return corrupt(reader.message());
  // Deflate packs at most 1032 to 1; what claims more than that cannot be in the file.
  const std::int64_t packed_at_least = (width * reader.bits_per_pixel() + 7) / 8 * height / 1032;
  if (packed_at_least > static_cast<std::int64_t>(bytes.size()))
    return corrupt("the file is too short for its size");
  if (reader.passes() > 1 && width * height > largest_raster / 4)
    return fail(Code::too_large, "the drawing is an interlaced PNG of more than 16 million pixels", file_name,
                "save it without interlacing");

  Raster raster{.width = static_cast<int>(width),
                .height = static_cast<int>(height),
                .channels = channels,
                .pixels = {},
                .pixel_mm = reader.pixel_mm(),
                .orientation = 1,
                .needs_colour = false};
  const std::size_t row_bytes = 4 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> row(row_bytes);
  if (reader.passes() == 1) {
    for (std::int64_t y = 0; y < height; ++y) {
      if (!reader.row(row.data())) return corrupt(reader.message());
      premultiply(row);
      if (!raster.append(row.data())) return raster;
    }
  } else {
    std::vector<std::uint8_t> image(row_bytes * static_cast<std::size_t>(height));
    for (int pass = 0; pass < reader.passes(); ++pass)
      for (std::int64_t y = 0; y < height; ++y)
        if (!reader.row(image.data() + static_cast<std::size_t>(y) * row_bytes))
          return corrupt(reader.message());
    for (std::int64_t y = 0; y < height; ++y) {
      std::copy_n(image.data() + static_cast<std::size_t>(y) * row_bytes, row_bytes, row.data());
      premultiply(row);
      if (!raster.append(row.data())) return raster;
    }
  }
  if (!reader.end()) return corrupt(reader.message());
  return raster;
}

}  // namespace vacuform
