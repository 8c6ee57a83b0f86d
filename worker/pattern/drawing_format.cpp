#include "worker/pattern/drawing_format.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "api/base/text.hpp"
#include "api/redaction/gunzip.hpp"
#include "api/redaction/redaction.hpp"
#include "worker/pattern/dxf_file.hpp"

namespace vacuform {

namespace {

using namespace std::string_view_literals;

constexpr std::size_t head_bytes = 1 << 16, most_unpacked = 32 << 20;

std::string_view view_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool begins_utf16_xml(std::string_view text) {
  return text.starts_with("\xff\xfe<\0"sv) || text.starts_with("\xfe\xff\0<"sv) ||
         text.starts_with("<\0"sv) || text.starts_with("\0<"sv);
}

// XML may begin with a byte order mark and white space.
bool begins_svg(std::string_view text) {
  if (begins_utf16_xml(text)) return true;
  std::string_view head = text.substr(0, head_bytes);
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  const auto first = head.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && head[first] == '<' && head.find("svg") != std::string_view::npos;
}

struct Foreign {
  std::string_view mark, name, fix;
  std::size_t at = 0;
};
constexpr std::string_view of_lines = "export the drawing as SVG from the program that made it",
                           of_pixels = "save it as PNG or JPEG";
constexpr Foreign foreign_formats[] = {
    {"%PDF", "a PDF or Adobe Illustrator file", of_lines},
    {"%!PS-Adobe", "a PostScript, EPS or Adobe Illustrator file", of_lines},
    {"\xc5\xd0\xd3\xc6"sv, "an EPS file", of_lines},
    {"II*\0"sv, "a TIFF picture", of_pixels},
    {"MM\0*"sv, "a TIFF picture", of_pixels},
    {"II+\0"sv, "a TIFF picture", of_pixels},
    {"MM\0+"sv, "a TIFF picture", of_pixels},
    {"WEBP", "a WebP picture", of_pixels, 8},
    {"GIF8", "a GIF picture", of_pixels},
    {"BM", "a BMP picture", of_pixels},
    {"8BPS", "a Photoshop file", of_pixels},
    {"ftypavif", "an AVIF picture", of_pixels, 4},
    {"ftyphei", "a HEIF picture", of_pixels, 4},
    {"ftypmif1", "a HEIF picture", of_pixels, 4},
    {"\0\0\0\x0cjP  "sv, "a JPEG 2000 picture", of_pixels},
    {"AutoCAD Binary DXF", "a binary DXF file", "save it as ASCII DXF or as SVG"},
    {"AC10", "a DWG file", of_lines},
    {"CDR", "a CorelDRAW file", of_lines, 8},
    {"PK\x03\x04", "a ZIP archive or an office document", "give the drawing itself, as SVG, PNG or JPEG"},
    {"\x1f\x8b"sv, "compressed", "unpack it: give a PNG, JPEG or SVG file"},
};

}  // namespace

DrawingFormat drawing_format(std::span<const std::uint8_t> bytes) {
  const std::string_view text = view_of(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return DrawingFormat::png;
  if (text.starts_with("\xff\xd8\xff")) return DrawingFormat::jpeg;
  if (text.starts_with(gzip_mark)) {
    const auto content = gunzip(MemorySource(text), most_unpacked);
    // A damaged or too large one is named by svg_text().
    return !content || begins_svg(*content) ? DrawingFormat::svg : DrawingFormat::other;
  }
  if (begins_dxf(text)) return DrawingFormat::dxf;
  return begins_svg(text) ? DrawingFormat::svg : DrawingFormat::other;
}

tl::unexpected<Error> unread_format(std::span<const std::uint8_t> bytes, const std::string& file_name) {
  const std::string_view text = view_of(bytes);
  for (const Foreign& f : foreign_formats)
    if (text.size() >= f.at && text.substr(f.at).starts_with(f.mark))
      return fail(Code::unsupported_format, std::string("the drawing is ").append(f.name), file_name,
                  std::string(f.fix));
  return fail(Code::unsupported_format, "the drawing is neither PNG, JPEG, SVG nor DXF", file_name,
              "give a PNG, JPEG, SVG or DXF file");
}

Result<std::string> svg_text(std::span<const std::uint8_t> bytes, const std::string& file_name) {
  const auto at_file = [&](Error error) {
    if (error.where.empty()) error.where = file_name;
    return tl::make_unexpected(std::move(error));
  };
  std::string text;
  if (view_of(bytes).starts_with(gzip_mark)) {
    auto content = gunzip(MemorySource(view_of(bytes)), most_unpacked);
    if (!content) return at_file(content.error());
    if (!begins_svg(*content)) return unread_format(bytes, file_name);
    text = std::move(*content);
  } else {
    text = view_of(bytes);
  }
  const bool wide = begins_utf16_xml(text);
  if (!wide && std::string_view(text).substr(0, head_bytes).find("<!ENTITY") == std::string_view::npos)
    return text;
  // The redacted copy is plain UTF-8. What it refuses for its entities is refused by the readers of the text, too.
  std::vector<std::uint8_t> copy(text.begin(), text.end());
  const auto plain = redact(copy, "drawing.svg");
  if (!plain && (wide || plain.error().code != Code::unsupported_format)) return at_file(plain.error());
  return plain ? std::string(copy.begin(), copy.end()) : text;
}

}  // namespace vacuform
