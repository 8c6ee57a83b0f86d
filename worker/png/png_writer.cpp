#include "worker/png/png_writer.hpp"

#include <png.h>
#include <zlib.h>

#include <cmath>
#include <new>
#include <stdexcept>

namespace vacuform {

struct PngWriter::State {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint8_t> bytes;
  bool out_of_memory = false;

  ~State() { png_destroy_write_struct(&png, &info); }

  // No input here is untrusted: an error is a fault of the caller or a lack of memory. libpng requires a longjmp, and
  // the methods that it jumps into hold only trivial locals.
  static void on_write(png_structp png, png_bytep data, std::size_t count) {
    auto* self = static_cast<State*>(png_get_io_ptr(png));
    try {
      self->bytes.insert(self->bytes.end(), data, data + count);
    } catch (const std::bad_alloc&) {
      self->out_of_memory = true;
    }
    if (self->out_of_memory) png_error(png, "out of memory");
  }
  [[noreturn]] static void on_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }
  [[noreturn]] void raise() const {
    if (out_of_memory) throw std::bad_alloc();
    throw std::logic_error("libpng refused to write");
  }

  bool begin(int width, int height, int color, png_uint_32 per_metre, bool srgb) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, this, on_write, [](png_structp) {});
    png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8, color,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (per_metre > 0) png_set_pHYs(png, info, per_metre, per_metre, PNG_RESOLUTION_METER);
    if (srgb) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_buffer_size(png, 1 << 18);
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_write_info(png, info);
    return true;
  }
  // Not by png_set_iCCP(), which raises an error for profiles that others read.
  bool profile(const std::uint8_t* content, std::size_t size) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_write_chunk(png, reinterpret_cast<png_const_bytep>("iCCP"), content, size);
    return true;
  }
  bool row(const std::uint8_t* pixels) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_write_row(png, pixels);
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png))) return false;
    png_write_end(png, nullptr);
    return true;
  }
};

namespace {

// Name, method of compression, and the profile.
std::vector<std::uint8_t> iccp_content(std::span<const std::uint8_t> icc) {
  constexpr char name[] = "ICC profile";  // with its end
  std::vector<std::uint8_t> out(name, name + sizeof name);
  out.push_back(0);
  const std::size_t head = out.size();
  uLongf packed = compressBound(static_cast<uLong>(icc.size()));
  out.resize(head + packed);
  if (compress2(out.data() + head, &packed, icc.data(), static_cast<uLong>(icc.size()), 9) != Z_OK)
    throw std::bad_alloc();
  out.resize(head + packed);
  return out;
}

}  // namespace

PngWriter::PngWriter(int width, int height, int channels, std::optional<double> dpi,
                     std::span<const std::uint8_t> icc)
    : state_(std::make_unique<State>()) {
  state_->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, State::on_error,
                                        [](png_structp, png_const_charp) {});
  if (state_->png) state_->info = png_create_info_struct(state_->png);
  if (!state_->info) throw std::bad_alloc();
  const int color = channels == 1   ? PNG_COLOR_TYPE_GRAY
                    : channels == 3 ? PNG_COLOR_TYPE_RGB
                                    : PNG_COLOR_TYPE_RGBA;
  const png_uint_32 per_metre = dpi ? static_cast<png_uint_32>(std::lround(*dpi / 0.0254)) : 0;
  if (!state_->begin(width, height, color, per_metre, dpi && icc.empty())) state_->raise();
  if (icc.empty()) return;
  const std::vector<std::uint8_t> chunk = iccp_content(icc);
  if (!state_->profile(chunk.data(), chunk.size())) state_->raise();
}
PngWriter::~PngWriter() = default;

void PngWriter::row(const std::uint8_t* pixels) {
  if (!state_->row(pixels)) state_->raise();
}

std::vector<std::uint8_t> PngWriter::finish() {
  if (!state_->end()) state_->raise();
  return std::move(state_->bytes);
}

}  // namespace vacuform
