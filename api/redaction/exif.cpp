#include "api/redaction/exif.hpp"

#include <algorithm>

namespace vacuform {

namespace {

constexpr std::string_view exif_mark{"Exif\0\0", 6};
constexpr std::uint32_t orientation_tag = 0x0112, x_tag = 0x011A, y_tag = 0x011B, unit_tag = 0x0128;
constexpr std::uint32_t short_type = 3, rational_type = 5;

std::string big_endian_bytes(std::uint32_t number, std::size_t size) {
  std::string out(size, '\0');
  for (std::size_t i = size; i-- > 0; number >>= 8) out[i] = static_cast<char>(number & 0xFF);
  return out;
}

}  // namespace

Exif read_exif(std::string_view segment) {
  Exif exif;
  if (!segment.starts_with(exif_mark)) return exif;
  const std::string_view tiff = segment.substr(exif_mark.size());
  const bool little = tiff.starts_with("II");
  const auto number = [&](std::size_t at, std::size_t size) -> std::uint32_t {
    if (at > tiff.size() || tiff.size() - at < size) return 0;
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < size; ++i)
      out = out << 8 | static_cast<unsigned char>(tiff[at + (little ? size - 1 - i : i)]);
    return out;
  };
  const std::size_t directory = number(4, 4);
  const std::size_t entries = number(directory, 2);
  Exif::Density density;
  std::uint32_t unit = 2;  // inches, if it is not said
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (entry + 12 > tiff.size()) break;
    const std::uint32_t tag = number(entry, 2), value = number(entry + 8, 2);
    if (tag == orientation_tag) exif.orientation = value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
    if (tag == unit_tag) unit = value;
    if ((tag == x_tag || tag == y_tag) && number(entry + 2, 2) == rational_type) {
      const std::size_t at = number(entry + 8, 4);
      (tag == x_tag ? density.x : density.y) = {number(at, 4), number(at + 4, 4)};
    }
  }
  const bool whole = density.x[0] > 0 && density.x[1] > 0 && density.y[0] > 0 && density.y[1] > 0;
  density.unit_mm = unit == 3 ? 10 : 25.4;
  if (whole && (unit == 2 || unit == 3)) exif.density = density;
  return exif;
}

std::string exif_segment(const Exif& exif) {
  const bool turned = exif.orientation != 1;
  if (!turned && !exif.density) return {};
  const std::uint32_t entries = (turned ? 1 : 0) + (exif.density ? 3 : 0);
  std::string directory = big_endian_bytes(entries, 2), values;
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, const std::string& value) {
    directory += big_endian_bytes(tag, 2) + big_endian_bytes(type, 2) + big_endian_bytes(1, 4) + value;
  };
  const auto small = [&](std::uint32_t value) { return big_endian_bytes(value, 2) + std::string(2, '\0'); };
  const auto rational = [&](std::uint32_t tag, const std::array<std::uint32_t, 2>& value) {
    entry(tag, rational_type,
          big_endian_bytes(8 + 2 + 12 * entries + 4 + static_cast<std::uint32_t>(values.size()), 4));
    values += big_endian_bytes(value[0], 4) + big_endian_bytes(value[1], 4);
  };
  if (turned) entry(orientation_tag, short_type, small(static_cast<std::uint32_t>(exif.orientation)));
  if (exif.density) {
    rational(x_tag, exif.density->x);
    rational(y_tag, exif.density->y);
    entry(unit_tag, short_type, small(exif.density->unit_mm == 10 ? 3 : 2));
  }
  return std::string(exif_mark) + std::string("MM\0*\0\0\0\x08", 8) + directory + std::string(4, '\0') +
         values;
}

}  // namespace vacuform
