// PNG and JPEG: the chunks and segments that make the picture. The pixels are never unpacked.
#include <algorithm>
#include <array>

#include "api/redaction/exif.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

namespace {

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

// The chunks about size, colour and pixels, and the most bytes that each may have (PNG, third edition, 11).
struct Chunk {
  std::string_view type;
  std::uint32_t most;
};
constexpr std::array<Chunk, 13> chunks{{{"IHDR", 13},
                                        {"PLTE", 768},
                                        {"IDAT", ~std::uint32_t{0}},
                                        {"IEND", 0},
                                        {"tRNS", 256},
                                        {"cHRM", 32},
                                        {"gAMA", 4},
                                        {"sBIT", 4},
                                        {"sRGB", 1},
                                        {"bKGD", 6},
                                        {"hIST", 512},
                                        {"pHYs", 9},
                                        {"cICP", 4}}};

// What stays of a segment of an application (APP0 to APP15) or of a comment; empty: the whole segment goes.
std::string kept_segment(unsigned char marker, std::string_view segment) {
  constexpr std::size_t jfif_size = 14, adobe_size = 12;
  if (marker == 0xE0 && segment.starts_with(std::string_view("JFIF\0", 5)) && segment.size() >= jfif_size)
    return std::string(segment.substr(0, jfif_size - 2)) + std::string(2, '\0');  // without its small picture
  if (marker == 0xEE && segment.starts_with("Adobe")) return std::string(segment.substr(0, adobe_size));
  if (marker != 0xE1) return {};
  return exif_segment(read_exif(segment));
}

// Copies entropy-coded data, up to the marker that ends it.
Result<void> coded_data(Cursor& in, Copy& out) {
  for (;;) {
    VACUFORM_TRY(some, in.some());
    if (some.empty()) return {};
    const std::size_t data = std::min(some.find('\xFF'), some.size());
    VACUFORM_CHECK(out.from(in, data));
    VACUFORM_TRY(mark, in.peek(2));
    if (mark.size() < 2) return out.from(in, mark.size());
    const auto next = static_cast<unsigned char>(mark[1]);
    if (mark[0] != '\xFF') continue;
    if (next != 0x00 && (next < 0xD0 || next > 0xD7)) return {};
    VACUFORM_CHECK(out.from(in, 2));
  }
}

}  // namespace

bool begins_png(std::string_view head) { return head.starts_with("\x89PNG\r\n\x1a\n"); }
bool begins_jpeg(std::string_view head) {
  return head.starts_with("\xff\xd8\xff") || head == "\xff\xd8";  // the latter of one without any segment
}

// A chunk is a length, a type, data and a checksum. The copy ends with IEND, or with a chunk that
// every reader must know and this one does not, without its data.
Result<void> png(Cursor& in, Copy& out) {
  VACUFORM_CHECK(out.from(in, 8));
  for (;;) {
    VACUFORM_TRY(head, in.peek(8));
    if (head.size() < 8) return {};
    const std::uint32_t length = big_endian(head.substr(0, 4));
    const std::string type(head.substr(4));
    const auto known =
        std::find_if(chunks.begin(), chunks.end(), [&](const Chunk& c) { return c.type == type; });
    if (known != chunks.end() && length <= known->most) {
      VACUFORM_CHECK(out.from(in, std::uint64_t{length} + 12));
    } else {
      if (type[0] < 'a' || type[0] > 'z') {
        VACUFORM_CHECK(out.from(in, 8));
        VACUFORM_TRY(data, in.skip(length));
        VACUFORM_CHECK(out.zeros(data));
        return out.from(in, 4);
      }
      VACUFORM_CHECK(in.skip(std::uint64_t{length} + 12));
    }
    if (type == "IEND") return {};
  }
}

// A segment is a marker, and, of most, a length and data. What stands between two segments goes, like what follows the end.
Result<void> jpeg(Cursor& in, Copy& out) {
  for (;;) {
    VACUFORM_TRY(some, in.some());
    if (some.empty()) return {};
    in.drop(std::min(some.find('\xFF'), some.size()));
    VACUFORM_TRY(mark, in.peek(2));
    if (mark.size() < 2) return {};
    if (mark[0] != '\xFF') continue;
    const auto marker = static_cast<unsigned char>(mark[1]);
    if (marker == 0xFF || marker == 0x00) {  // filling, or no marker
      in.drop(1);
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD9)) {
      VACUFORM_CHECK(out.from(in, 2));
      if (marker == 0xD9) return {};
      continue;
    }
    VACUFORM_TRY(head, in.peek(4));
    if (head.size() < 4) return out.from(in, head.size());
    const std::size_t length = std::max<std::uint32_t>(2, big_endian(head.substr(2)));
    if ((marker >= 0xE0 && marker <= 0xEF) || marker == 0xFE) {
      const std::string mark_and_length(head);
      VACUFORM_TRY(whole, in.take(length + 2));
      if (whole.size() < length + 2) return out.write(mark_and_length);  // the file ends here, too
      const std::string left = kept_segment(marker, whole.substr(4));
      if (left.empty()) continue;
      const std::size_t size = left.size() + 2;
      const char begin[] = {'\xFF', static_cast<char>(marker), static_cast<char>(size >> 8),
                            static_cast<char>(size & 0xFF)};
      VACUFORM_CHECK(out.write({begin, sizeof begin}));
      VACUFORM_CHECK(out.write(left));
    } else {
      VACUFORM_CHECK(out.from(in, length + 2));
      if (marker == 0xDA) VACUFORM_CHECK(coded_data(in, out));
    }
  }
}

}  // namespace vacuform::redaction
