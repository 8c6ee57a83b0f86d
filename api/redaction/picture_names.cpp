#include "api/redaction/picture_names.hpp"

#include <algorithm>
#include <array>

namespace vacuform {

namespace {

constexpr std::array<std::uint32_t, 256> crc_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}();

std::uint32_t crc_step(std::uint32_t crc, char c) {
  return crc_table[(crc ^ static_cast<unsigned char>(c)) & 0xFF] ^ (crc >> 8);
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

class PngNames : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    while (!in.empty()) {
      if (signature_ == 0 && !after_end_ && !blank_ && data_ > 0) {  // most of the file
        const std::string_view kept = in.substr(0, data_);
        out += kept;
        data_ -= static_cast<std::uint32_t>(kept.size());
        in.remove_prefix(kept.size());
      } else {
        step(in[0], out);
        in.remove_prefix(1);
      }
    }
  }
  void end(std::string& out) override { out += head_; }
  void fields(FilterState& state) override {
    state(head_, signature_, data_, checksum_, crc_, blank_, end_, after_end_);
  }

 private:
  static constexpr std::string_view empty_chunk = "vfNo";  // ancillary, private, safe to copy

  void step(char c, std::string& out) {
    if (signature_ > 0) {
      --signature_;
      out += c;
    } else if (after_end_) {
      out += '\0';
    } else if (data_ > 0) {
      --data_;
      const char kept = blank_ ? '\0' : c;
      if (blank_) crc_ = crc_step(crc_, kept);
      out += kept;
    } else if (checksum_ > 0) {
      --checksum_;
      out += blank_ ? static_cast<char>((crc_ ^ 0xFFFFFFFFu) >> (8 * checksum_) & 0xFF) : c;
      after_end_ = checksum_ == 0 && end_;
    } else {
      head_ += c;
      if (head_.size() == 8) begin_chunk(out);
    }
  }

  // Ancillary chunks, whose types start with a small letter, except those about size and colour. An invalid type stays,
  // and the reader refuses it.
  static bool telling(std::string_view type) {
    constexpr std::array<std::string_view, 9> kept{"tRNS", "cHRM", "gAMA", "sBIT", "sRGB",
                                                   "bKGD", "hIST", "pHYs", "cICP"};
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return type[0] >= 'a' && type[0] <= 'z' && std::all_of(type.begin(), type.end(), letter) &&
           std::find(kept.begin(), kept.end(), type) == kept.end();
  }

  void begin_chunk(std::string& out) {
    const std::string type = head_.substr(4);
    data_ = big_endian(head_.substr(0, 4));
    checksum_ = 4;
    end_ = type == "IEND";
    blank_ = telling(type);
    out += head_.substr(0, 4);
    out += blank_ ? empty_chunk : type;
    crc_ = 0xFFFFFFFFu;
    for (const char c : empty_chunk) crc_ = crc_step(crc_, c);
    head_.clear();
  }

  std::string head_;  // length and type of a chunk, until it is whole
  std::uint32_t signature_ = 8, data_ = 0, checksum_ = 0, crc_ = 0;
  bool blank_ = false, end_ = false, after_end_ = false;
};

// The orientation (1 to 8) of the first directory of an Exif segment; 1 if it has none.
int exif_orientation(std::string_view segment) {
  constexpr std::string_view mark{"Exif\0\0", 6};
  if (!segment.starts_with(mark)) return 1;
  const std::string_view tiff = segment.substr(mark.size());
  const bool little = tiff.starts_with("II");
  const auto number = [&](std::size_t at, std::size_t size) -> std::uint32_t {
    if (at > tiff.size() || tiff.size() - at < size) return 0;
    std::string bytes(tiff.substr(at, size));
    if (little) std::reverse(bytes.begin(), bytes.end());
    return big_endian(bytes);
  };
  const std::size_t directory = number(4, 4);
  const std::size_t entries = number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (entry + 12 > tiff.size()) break;
    if (number(entry, 2) != 0x0112) continue;
    const std::uint32_t orientation = number(entry + 8, 2);
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

// An Exif segment of the same length that contains only the orientation.
std::string exif_of(int orientation, std::size_t size) {
  std::string exif("Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 25);
  exif += static_cast<char>(orientation);
  if (orientation == 1 || size < exif.size() + 6) exif.clear();
  exif.resize(size, '\0');
  return exif;
}

class JpegNames : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    while (!in.empty()) {
      if (place_ == Place::picture) {  // most of the file
        const std::string_view kept = in.substr(0, in.find('\xFF'));
        out += kept;
        in.remove_prefix(kept.size());
        if (in.empty()) return;
      }
      step(static_cast<unsigned char>(in[0]), out);
      in.remove_prefix(1);
    }
  }
  void end(std::string& out) override {
    if (segment_ > 0) finish_segment(out, held_.size());
  }
  void fields(FilterState& state) override { state(place_, marker_, segment_, held_); }

 private:
  enum class Place { picture, marker, length_high, length_low, segment, after_end };

  void step(unsigned char c, std::string& out) {
    switch (place_) {
      case Place::picture:  // entropy-coded data, or between two segments
        out += static_cast<char>(c);
        if (c == 0xFF) place_ = Place::marker;
        return;
      case Place::marker:
        out += static_cast<char>(c);
        marker_ = c;
        if (c == 0xFF) return;  // filling
        place_ = c == 0xD9                                            ? Place::after_end
                 : c == 0x00 || c == 0x01 || (c >= 0xD0 && c <= 0xD8) ? Place::picture
                                                                      : Place::length_high;
        return;
      case Place::length_high:
        out += static_cast<char>(c);
        segment_ = static_cast<std::size_t>(c) << 8;
        place_ = Place::length_low;
        return;
      case Place::length_low:
        out += static_cast<char>(c);
        segment_ += c;
        segment_ -= std::min<std::size_t>(segment_, 2);
        place_ = segment_ > 0 ? Place::segment : Place::picture;
        return;
      case Place::segment:
        held_ += static_cast<char>(c);
        if (held_.size() < segment_) return;
        finish_segment(out, segment_);
        place_ = Place::picture;
        return;
      case Place::after_end:
        out += '\0';
        return;
    }
  }

  void finish_segment(std::string& out, std::size_t size) {
    const bool application = marker_ >= 0xE0 && marker_ <= 0xEF, comment = marker_ == 0xFE;
    // Of JFIF all but the small picture behind its 14 bytes, of Adobe what says how the colours are coded.
    const std::size_t kept = !application && !comment                                              ? size
                             : marker_ == 0xE0 && held_.starts_with(std::string_view("JFIF\0", 5)) ? jfif_size
                             : marker_ == 0xEE && held_.starts_with("Adobe") ? adobe_size
                                                                             : 0;
    if (marker_ == 0xE1) {
      out += exif_of(exif_orientation(held_), size);
    } else {
      held_.resize(std::min(size, kept));
      held_.resize(size, '\0');
      out += held_;
    }
    held_.clear();
    segment_ = 0;
  }

  static constexpr std::size_t jfif_size = 14, adobe_size = 12;
  Place place_ = Place::picture;
  unsigned char marker_ = 0;
  std::size_t segment_ = 0;
  std::string held_;  // of the segment; at most 64 KiB
};

}  // namespace

std::unique_ptr<NameFilter::Format> png_names() { return std::make_unique<PngNames>(); }
std::unique_ptr<NameFilter::Format> jpeg_names() { return std::make_unique<JpegNames>(); }

}  // namespace vacuform
