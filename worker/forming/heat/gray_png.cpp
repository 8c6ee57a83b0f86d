#include "worker/forming/heat/gray_png.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <new>

namespace vacuform {

namespace {

constexpr std::int64_t most_pixels = 4'000'000;

// libpng reports errors by longjmp; the methods that call it hold only trivial locals, so none is skipped.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
    if (png_) info_ = png_create_info_struct(png_);
    if (!png_ || !info_) throw std::bad_alloc();
  }
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  // Up to the first row; rows will be of 16-bit gray, the high byte first.
  bool begin() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_read_fn(png_, this, on_read);
    png_set_user_limits(png_, 1'000'000, 1'000'000);
    png_set_chunk_malloc_max(png_, 4 << 20);
    png_set_chunk_cache_max(png_, 64);
    // Compressed texts and profiles say nothing of the temperature and can be bombs.
    static const png_byte ignored[] = "iCCP\0zTXt\0iTXt\0tEXt\0sPLT\0eXIf";
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, ignored, 6);
    png_read_info(png_, info_);
    passes_ = png_set_interlace_handling(png_);
    png_set_expand_16(png_);
    png_set_strip_alpha(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  bool row(std::uint8_t* out) {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_row(png_, out, nullptr);
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_end(png_, nullptr);
    return true;
  }
  int passes() const { return passes_; }
  std::size_t row_bytes() { return png_get_rowbytes(png_, info_); }
  const char* message() const { return message_; }

 private:
  [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
    auto* self = static_cast<Reader*>(png_get_error_ptr(png));
    std::strncpy(self->message_, message, sizeof self->message_ - 1);
    png_longjmp(png, 1);
  }
  static void on_read(png_structp png, png_bytep out, std::size_t count) {
    auto* self = static_cast<Reader*>(png_get_io_ptr(png));
    if (count > self->bytes_.size() - self->position_) png_error(png, "the file ends early");
    std::memcpy(out, self->bytes_.data() + self->position_, count);
    self->position_ += count;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
  char message_[96] = {};
};

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() >= signature.size() && std::equal(signature.begin(), signature.end(), bytes.begin());
}

Result<GrayPicture> read_gray_png(std::span<const std::uint8_t> bytes, const std::string& file_name) {
  const auto corrupt = [&](const std::string& what) {
    return fail(Code::corrupt_file, "the PNG is damaged: " + what, file_name, "export the picture again");
  };
  if (bytes.size() < 33 || !is_png(bytes)) return corrupt("the file ends early");
  // From the header itself: libpng's own limits cannot tell a large picture from a damaged one.
  const auto big_endian = [&](std::size_t at) {
    return std::int64_t{bytes[at]} << 24 | std::int64_t{bytes[at + 1]} << 16 |
           std::int64_t{bytes[at + 2]} << 8 | std::int64_t{bytes[at + 3]};
  };
  const std::int64_t width = big_endian(16), height = big_endian(20);
  const int depth = bytes[24], colour_type = bytes[25];
  if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return corrupt("it has no size");
  if (width > 1'000'000 || height > 1'000'000 || width * height > most_pixels)
    return fail(Code::too_large,
                "the picture has " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                file_name, "give one of at most 4 million pixels");
  if (colour_type != PNG_COLOR_TYPE_GRAY && colour_type != PNG_COLOR_TYPE_GRAY_ALPHA)
    return fail(Code::unsupported_format, "the picture of temperatures is in colour, which has no scale",
                file_name, "export it as gray, or the temperatures as CSV");
  const int channels = colour_type == PNG_COLOR_TYPE_GRAY ? 1 : 2;
  // Deflate packs at most 1032 to 1; what claims more than that cannot be in the file.
  if ((width * depth * channels + 7) / 8 * height / 1032 > static_cast<std::int64_t>(bytes.size()))
    return corrupt("the file is too short for its size");

  Reader reader(bytes);
  if (!reader.begin()) return corrupt(reader.message());
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(width);
  if (reader.row_bytes() != row_bytes) return corrupt("its header contradicts itself");
  std::vector<std::uint8_t> rows(row_bytes * static_cast<std::size_t>(height));
  for (int pass = 0; pass < reader.passes(); ++pass)
    for (std::int64_t y = 0; y < height; ++y)
      if (!reader.row(rows.data() + static_cast<std::size_t>(y) * row_bytes))
        return corrupt(reader.message());
  if (!reader.end()) return corrupt(reader.message());
  GrayPicture picture{static_cast<int>(width), static_cast<int>(height), {}};
  picture.pixels.reserve(rows.size() / 2);
  for (std::size_t i = 0; i < rows.size(); i += 2)
    picture.pixels.push_back(static_cast<std::uint16_t>(rows[i] << 8 | rows[i + 1]));
  return picture;
}

}  // namespace vacuform
