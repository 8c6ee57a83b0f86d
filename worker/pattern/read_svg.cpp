#include <cairo.h>
#include <librsvg/rsvg.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <pugixml.hpp>

#include "worker/pattern/raster.hpp"

namespace vacuform {
namespace {

struct Release {
  void operator()(RsvgHandle* h) const { g_object_unref(h); }
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Handle = std::unique_ptr<RsvgHandle, Release>;

tl::unexpected<Error> corrupt(const std::string& what, const std::string& file_name) {
  return fail(Code::corrupt_file, "the SVG cannot be read: " + what, file_name,
              "export the drawing again as plain SVG");
}

// Takes the error's text and frees it.
std::string take(GError* error) {
  std::string text = error ? error->message : "unknown fault";
  if (error) g_error_free(error);
  return text;
}

// Handles made from bytes have no base address: librsvg then resolves no reference but "data:" and "#".
Result<Handle> load(const std::string& text, const std::string& file_name) {
  GError* error = nullptr;
  Handle handle(rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(text.data()), text.size(), &error));
  if (!handle) return corrupt(take(error), file_name);
  return handle;
}

// librsvg decodes a picture inside the drawing with a library of many formats and no limits. So it is decoded here
// first, where sizes are checked, and only what passes is left in. `pixels` counts over the whole drawing.
Result<void> check_embedded(std::string_view address, const std::string& file_name, std::int64_t& pixels) {
  const auto comma = address.find(',');
  const std::string_view kind = address.substr(0, comma);
  const bool png = kind == "data:image/png;base64",
             jpeg = kind == "data:image/jpeg;base64" || kind == "data:image/jpg;base64";
  if (comma == std::string_view::npos || (!png && !jpeg))
    return fail(Code::unsupported_format, "the SVG holds a picture that is neither PNG nor JPEG", file_name,
                "embed it as PNG or JPEG");
  const std::string text(address.substr(comma + 1));
  gsize size = 0;
  const std::unique_ptr<guchar, void (*)(gpointer)> data(g_base64_decode(text.c_str(), &size), g_free);
  const std::span<const std::uint8_t> bytes(data.get(), size);
  const std::string name = file_name + ", embedded picture";
  VACUFORM_TRY(raster, png ? read_png(bytes, name, {}) : read_jpeg(bytes, name, {}));
  pixels += std::int64_t{raster.width} * raster.height;
  if (pixels > largest_raster / 4)
    return fail(Code::too_large, "the pictures inside the SVG have more than 16 million pixels", file_name,
                "reduce them, or give the picture itself");
  return {};
}

// The name of the other file is not repeated: in a job, it was replaced by spaces before the drawing was stored.
tl::unexpected<Error> refers_elsewhere(std::string_view element, const std::string& text,
                                       std::ptrdiff_t offset, const std::string& file_name) {
  const auto place = text.begin() + std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text));
  const auto line = 1 + std::count(text.begin(), place, '\n');
  return fail(Code::unusable_pattern,
              "the SVG refers to another file in its <" + std::string(element.substr(0, 16)) +
                  "> element on line " + std::to_string(line),
              file_name, "embed the picture in the drawing, or give the picture itself");
}

// librsvg would silently leave out what it may not load; a drawing with a hole is worse than a refusal.
Result<SvgWork> check(const std::string& text, const std::string& file_name) {
  pugi::xml_document document;
  const auto parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default | pugi::parse_doctype);
  if (!parsed) return corrupt(parsed.description(), file_name);
  const std::string_view root = document.document_element().name();
  if (root != "svg" && !root.ends_with(":svg"))
    return fail(Code::unsupported_format, "the drawing is XML, but not SVG", file_name,
                "give a PNG, JPEG or SVG file");

  // Entities may stand for names (drawing programs declare their namespaces so), but not for elements or
  // attributes that this walk would not see.
  for (const pugi::xml_node node : document.children()) {
    if (node.type() != pugi::node_doctype) continue;
    const std::string_view declared = node.value();
    bool markup = declared.find("&#") != declared.npos || declared.find("data:") != declared.npos ||
                  declared.find("<!ATTLIST") != declared.npos;
    for (auto at = declared.find('<'); at != declared.npos; at = declared.find('<', at + 1))
      markup |= at + 1 == declared.size() || declared[at + 1] != '!';
    if (markup)
      return fail(Code::unsupported_format, "the SVG's document type declares parts of the drawing",
                  file_name, "save it as plain SVG");
  }

  int depth = 0;
  std::int64_t pixels = 0;
  for (pugi::xml_node node = document.document_element(); node;) {
    const std::string_view tag = node.name(), local = tag.substr(tag.find(':') + 1);
    if (local == "image" || local == "use" || local == "feImage")
      for (const pugi::xml_attribute attribute : node.attributes()) {
        const std::string_view key = attribute.name(), target = attribute.value();
        if (key != "href" && !key.ends_with(":href")) continue;
        if (target.starts_with("data:")) {
          VACUFORM_CHECK(check_embedded(target, file_name, pixels));
        } else if (!target.empty() && !target.starts_with('#')) {
          return refers_elsewhere(local, text, node.offset_debug(), file_name);
        }
      }
    // librsvg 2.54 ends the process at a matrix of more than 400 numbers, which take more bytes than this.
    constexpr std::size_t longest_matrix = 800;
    if (local == "feConvolveMatrix" &&
        std::string_view(node.attribute("kernelMatrix").value()).size() > longest_matrix)
      return fail(Code::too_large, "the SVG has a filter matrix of more than 800 bytes", file_name,
                  "remove the filter feConvolveMatrix, or give a picture");
    if (node.first_child()) {
      if (++depth > 200) return corrupt("its elements are nested more than 200 deep", file_name);
      node = node.first_child();
    } else {
      while (node && !node.next_sibling()) node = node.parent(), --depth;
      if (node) node = node.next_sibling();
    }
  }
  return work_to_draw(document, file_name);
}

}  // namespace

Result<SvgWork> check_svg(const std::string& text, const std::string& file_name) {
  if (text.size() > 32u << 20)
    return fail(Code::too_large, "the SVG has more than 32 MB", file_name, "simplify the drawing");
  VACUFORM_TRY(work, check(text, file_name));
  VACUFORM_CHECK(load(text, file_name));
  return work;
}

Result<Raster> draw_svg(const std::string& text, const std::string& file_name, int width, int height,
                        int channels) {
  VACUFORM_TRY(handle, load(text, file_name));
  Raster raster{.width = width,
                .height = height,
                .channels = channels,
                .pixels = {},
                .pixel_mm = {},
                .exif_pixel_mm = {},
                .orientation = 1,
                .needs_colour = false};
  // Band by band, so that the memory is that of the result and not of cairo's four bytes a pixel.
  const int band = std::clamp(4'000'000 / width, 1, height);
  std::unique_ptr<cairo_surface_t, Release> surface(
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, band));
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS)
    return fail(Code::too_large, "the drawing is too wide to be drawn", file_name, "give a lower print.dpi");
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(width));

  for (int top = 0; top < height; top += band) {
    std::unique_ptr<cairo_t, Release> cairo(cairo_create(surface.get()));
    cairo_set_operator(cairo.get(), CAIRO_OPERATOR_CLEAR);
    cairo_paint(cairo.get());
    cairo_set_operator(cairo.get(), CAIRO_OPERATOR_OVER);
    cairo_translate(cairo.get(), 0, -top);
    const RsvgRectangle viewport{0, 0, static_cast<double>(width), static_cast<double>(height)};
    GError* error = nullptr;
    if (!rsvg_handle_render_document(handle.get(), cairo.get(), &viewport, &error))
      return corrupt(take(error), file_name);
    cairo.reset();
    cairo_surface_flush(surface.get());
    const unsigned char* data = cairo_image_surface_get_data(surface.get());
    const int stride = cairo_image_surface_get_stride(surface.get());
    for (int y = 0; y < std::min(band, height - top); ++y) {
      const unsigned char* row = data + static_cast<std::ptrdiff_t>(y) * stride;
      for (int x = 0; x < width; ++x) {
        std::uint32_t pixel;
        std::memcpy(&pixel, row + 4 * static_cast<std::ptrdiff_t>(x), 4);
        std::uint8_t* out = &rgba[4 * static_cast<std::size_t>(x)];
        out[0] = static_cast<std::uint8_t>(pixel >> 16);
        out[1] = static_cast<std::uint8_t>(pixel >> 8);
        out[2] = static_cast<std::uint8_t>(pixel);
        out[3] = static_cast<std::uint8_t>(pixel >> 24);
      }
      if (!raster.append(rgba.data())) return raster;
    }
  }
  return raster;
}

}  // namespace vacuform
