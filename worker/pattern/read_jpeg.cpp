#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>

// jpeglib.h needs the types of stdio first.
#include <jpeglib.h>

#include "api/redaction/exif.hpp"
#include "worker/pattern/raster.hpp"

namespace vacuform {
namespace {

// libjpeg reports errors by a call that must not return: longjmp, out of methods with only trivial locals.
class JpegReader {
 public:
  explicit JpegReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    decoder_.err = jpeg_std_error(&errors_);
    decoder_.client_data = this;
    errors_.error_exit = [](j_common_ptr d) { self(d).leave(d); };
    errors_.output_message = [](j_common_ptr) {};
    errors_.emit_message = [](j_common_ptr d, int level) {
      // A warning means that libjpeg made up pixels: the drawing would be printed with a hole.
      if (level < 0) self(d).leave(d);
    };
    // Progressive files can hold thousands of scans over one picture (the "JPEG bomb").
    progress_.progress_monitor = [](j_common_ptr d) {
      if (d->is_decompressor && reinterpret_cast<j_decompress_ptr>(d)->input_scan_number > 200) {
        std::strcpy(self(d).message_, "it has more than 200 scans");
        std::longjmp(self(d).jump_, 1);
      }
    };
  }
  ~JpegReader() {
    if (created_) jpeg_destroy_decompress(&decoder_);
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  bool header() {
    if (setjmp(jump_)) return false;
    jpeg_create_decompress(&decoder_);
    created_ = true;
    decoder_.client_data = this;
    decoder_.progress = &progress_;
    decoder_.mem->max_memory_to_use = 512L << 20;
    jpeg_save_markers(&decoder_, JPEG_APP0 + 1, 0xffff);
    jpeg_mem_src(&decoder_, bytes_.data(), bytes_.size());
    return jpeg_read_header(&decoder_, TRUE) == JPEG_HEADER_OK;
  }
  bool begin() {
    if (setjmp(jump_)) return false;
    decoder_.out_color_space = JCS_RGB;
    decoder_.dct_method = JDCT_ISLOW;
    return jpeg_start_decompress(&decoder_);
  }
  bool row(std::uint8_t* rgb) {
    if (setjmp(jump_)) return false;
    JSAMPROW rows[1] = {rgb};
    return jpeg_read_scanlines(&decoder_, rows, 1) == 1;
  }
  bool end() {
    if (setjmp(jump_)) return false;
    return jpeg_finish_decompress(&decoder_);
  }

  const jpeg_decompress_struct& info() const { return decoder_; }
  const char* message() const { return message_; }

 private:
  static JpegReader& self(j_common_ptr d) { return *static_cast<JpegReader*>(d->client_data); }
  [[noreturn]] void leave(j_common_ptr d) {
    d->err->format_message(d, message_);
    std::longjmp(jump_, 1);
  }

  std::span<const std::uint8_t> bytes_;
  jpeg_decompress_struct decoder_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf jump_;
  bool created_ = false;
  char message_[JMSG_LENGTH_MAX] = "unknown fault";
};

std::optional<Eigen::Vector2d> pixel_mm(const jpeg_decompress_struct& info) {
  if (!info.saw_JFIF_marker || info.X_density == 0 || info.Y_density == 0) return std::nullopt;
  if (info.density_unit == 1) return Eigen::Vector2d(25.4 / info.X_density, 25.4 / info.Y_density);
  if (info.density_unit == 2) return Eigen::Vector2d(10.0 / info.X_density, 10.0 / info.Y_density);
  return std::nullopt;
}

}  // namespace

Result<Raster> read_jpeg(std::span<const std::uint8_t> bytes, const std::string& file_name,
                         const RasterUse& use) {
  JpegReader reader(bytes);
  const auto corrupt = [&] {
    return fail(Code::corrupt_file, std::string("the JPEG is damaged: ") + reader.message(), file_name,
                std::string("export the ") + use.noun() + " again");
  };
  if (!reader.header()) return corrupt();
  const auto& info = reader.info();
  const std::int64_t width = info.image_width, height = info.image_height;
  if (width * height > use.most_pixels) return too_many_pixels(width, height, file_name, use);
  if (info.num_components != 1 && info.num_components != 3)
    return fail(Code::unsupported_format, "the JPEG is in CMYK colours", file_name,
                "save it in RGB or grayscale");

  Raster raster{.width = static_cast<int>(width),
                .height = static_cast<int>(height),
                .channels = use.channels,
                .pixels = {},
                .pixel_mm = pixel_mm(info),
                .exif_pixel_mm = {},
                .orientation = 1,
                .needs_colour = false};
  for (auto* marker = info.marker_list; marker; marker = marker->next) {
    const Exif exif = read_exif({reinterpret_cast<const char*>(marker->data), marker->data_length});
    if (exif.orientation != 1) raster.orientation = exif.orientation;
    if (!exif.density) continue;
    const Eigen::Vector2d pixel(exif.density->pixel_width_mm(), exif.density->pixel_height_mm());
    (raster.pixel_mm ? raster.exif_pixel_mm : raster.pixel_mm) = pixel;
  }

  if (!reader.begin()) return corrupt();
  std::vector<std::uint8_t> rgb(3 * static_cast<std::size_t>(width)),
      rgba(4 * static_cast<std::size_t>(width), use.texture ? 0 : 255);
  for (std::int64_t y = 0; y < height; ++y) {
    if (!reader.row(rgb.data())) return corrupt();
    for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x)
      std::memcpy(&rgba[4 * x], &rgb[3 * x], 3);
    if (!raster.append(rgba.data())) return raster;
  }
  if (!reader.end()) return corrupt();
  if (!use.texture) raster.turn_upright();
  return raster;
}

}  // namespace vacuform
