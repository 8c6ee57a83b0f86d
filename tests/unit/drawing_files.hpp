// Drawings as bytes, made by hand, and a reader for the pictures that come out.
#pragma once

#include <png.h>
#include <zlib.h>

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <jpeglib.h>

namespace vacuform::drawing_files {

using Bytes = std::vector<std::uint8_t>;

inline Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

inline void put32(Bytes& out, std::uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(v >> shift));
}

inline void put_chunk(Bytes& out, const std::string& name, const Bytes& data) {
  put32(out, static_cast<std::uint32_t>(data.size()));
  Bytes body = bytes_of(name);
  body.insert(body.end(), data.begin(), data.end());
  out.insert(out.end(), body.begin(), body.end());
  put32(out, static_cast<std::uint32_t>(crc32(0, body.data(), static_cast<uInt>(body.size()))));
}

inline Bytes deflated(const Bytes& data) {
  uLongf size = compressBound(data.size());
  Bytes out(size);
  if (compress2(out.data(), &size, data.data(), data.size(), 9) != Z_OK) throw std::runtime_error("zlib");
  out.resize(size);
  return out;
}

// A PNG from its parts, right or wrong: `rows` are raw scan lines without their filter bytes; `extra` are
// chunks between IHDR and IDAT, already packed.
inline Bytes png(std::uint32_t width, std::uint32_t height, int depth, int color,
                 const std::vector<Bytes>& rows, const Bytes& extra = {}) {
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, header, raw;
  put32(header, width);
  put32(header, height);
  for (const int v : {depth, color, 0, 0, 0}) header.push_back(static_cast<std::uint8_t>(v));
  put_chunk(out, "IHDR", header);
  out.insert(out.end(), extra.begin(), extra.end());
  for (const auto& row : rows) {
    raw.push_back(0);
    raw.insert(raw.end(), row.begin(), row.end());
  }
  put_chunk(out, "IDAT", deflated(raw));
  put_chunk(out, "IEND", {});
  return out;
}

inline Bytes phys(std::uint32_t x, std::uint32_t y, int unit = 1) {
  Bytes data, out;
  put32(data, x);
  put32(data, y);
  data.push_back(static_cast<std::uint8_t>(unit));
  put_chunk(out, "pHYs", data);
  return out;
}

// An 8-bit gray PNG of `gray(x, y)`, row 0 at the top, at `per_metre` pixels a metre.
inline Bytes gray_png(int width, int height, std::uint32_t per_metre,
                      const std::function<int(int, int)>& gray) {
  std::vector<Bytes> rows;
  for (int y = 0; y < height; ++y) {
    Bytes row;
    for (int x = 0; x < width; ++x) row.push_back(static_cast<std::uint8_t>(gray(x, y)));
    rows.push_back(row);
  }
  return png(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 8, 0, rows,
             phys(per_metre, per_metre));
}

// A JPEG of `channels` (1 gray, 3 RGB, 4 CMYK) at 254 dpi, with an Exif orientation when it is not 0.
inline Bytes jpeg(int width, int height, int channels, const std::function<int(int, int, int)>& value,
                  int orientation = 0, bool progressive = false) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &memory, &size);
  encoder.image_width = static_cast<JDIMENSION>(width);
  encoder.image_height = static_cast<JDIMENSION>(height);
  encoder.input_components = channels;
  encoder.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 98, TRUE);
  encoder.density_unit = 1;
  encoder.X_density = encoder.Y_density = 254;
  if (progressive) jpeg_simple_progression(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  if (orientation) {
    Bytes exif = {'E', 'x', 'i', 'f',  0,    0, 'M', 'M', 0, 42, 0, 0, 0,
                  8,   0,   1,   0x01, 0x12, 0, 3,   0,   0, 0,  1, 0, static_cast<std::uint8_t>(orientation),
                  0,   0,   0,   0,    0,    0};
    jpeg_write_marker(&encoder, JPEG_APP0 + 1, exif.data(), static_cast<unsigned>(exif.size()));
  }
  Bytes row(static_cast<std::size_t>(width * channels));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        row[static_cast<std::size_t>(x * channels + c)] = static_cast<std::uint8_t>(value(x, y, c));
    JSAMPROW rows[1] = {row.data()};
    jpeg_write_scanlines(&encoder, rows, 1);
  }
  jpeg_finish_compress(&encoder);
  Bytes out(memory, memory + size);
  jpeg_destroy_compress(&encoder);
  std::free(memory);
  return out;
}

struct Decoded {
  int width = 0, height = 0;
  Bytes rgba;
  int at(int x, int y, int c = 0) const { return rgba[static_cast<std::size_t>(4 * (y * width + x) + c)]; }
};
inline Decoded decode_png(std::span<const std::uint8_t> bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
    throw std::runtime_error(image.message);
  image.format = PNG_FORMAT_RGBA;
  Decoded out{static_cast<int>(image.width), static_cast<int>(image.height), Bytes(PNG_IMAGE_SIZE(image))};
  if (!png_image_finish_read(&image, nullptr, out.rgba.data(), 0, nullptr))
    throw std::runtime_error(image.message);
  return out;
}

// The position just behind the name of the first chunk so called; 0 where there is none.
inline std::size_t chunk(std::span<const std::uint8_t> png_bytes, const std::string& name) {
  const std::string text(png_bytes.begin(), png_bytes.end());
  const auto at = text.find(name);
  return at == std::string::npos ? 0 : at + name.size();
}

}  // namespace vacuform::drawing_files
