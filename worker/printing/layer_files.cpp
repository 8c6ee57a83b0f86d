#include "worker/printing/layer_files.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "worker/png/png_writer.hpp"
#include "worker/printing/print_pdf.hpp"
#include "worker/printing/print_svg.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

// Lays the marks over a row of the print, as black ink.
void lay_over(const std::uint8_t* marks, int width, int channels, std::uint8_t* row) {
  for (int x = 0; x < width; ++x) {
    const int m = marks[x];
    if (m == 0) continue;
    std::uint8_t* p = row + static_cast<std::ptrdiff_t>(x) * channels;
    if (channels == 1) {
      p[0] = static_cast<std::uint8_t>((p[0] * (255 - m) + 127) / 255);
    } else {
      const int under = (p[3] * (255 - m) + 127) / 255, alpha = m + under;
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>((p[c] * under + alpha / 2) / alpha);
      p[3] = static_cast<std::uint8_t>(alpha);
    }
  }
}

void reverse(std::vector<std::uint8_t>& row, int channels) {
  const std::size_t n = static_cast<std::size_t>(channels), width = row.size() / n;
  for (std::size_t a = 0, b = width - 1; a < b; ++a, --b)
    std::swap_ranges(row.begin() + static_cast<std::ptrdiff_t>(a * n),
                     row.begin() + static_cast<std::ptrdiff_t>(a * n + n),
                     row.begin() + static_cast<std::ptrdiff_t>(b * n));
}

// The PNG files of the part of the sheet that a picture covers, made along with the whole. PDF stores colour and
// opacity separately.
class PictureFiles {
 public:
  PictureFiles(const PixelBox& box, int channels, double dpi, std::span<const std::uint8_t> icc)
      : box_(box), channels_(channels), whole_(width(), height(), channels, dpi, icc) {
    if (channels != 4) return;
    colour_.emplace(width(), height(), 3, dpi);
    opacity_.emplace(width(), height(), 1, dpi);
    rgb_.resize(3 * static_cast<std::size_t>(width()));
    alpha_.resize(static_cast<std::size_t>(width()));
  }

  // Rows [top, bottom) of the whole print of this width, before any mirroring.
  void rows(int top, int bottom, int width, const std::uint8_t* pixels) {
    const int first = std::max(top, box_.top), last = std::min(bottom, box_.bottom);
    const auto each = [&](auto&& write) {
      for (int y = first; y < last; ++y)
        write(pixels + (static_cast<std::ptrdiff_t>(y - top) * width + box_.left) * channels_);
    };
    const auto whole = [&] { each([&](const std::uint8_t* row) { whole_.row(row); }); };
    if (!colour_) return whole();
    together(
        whole,
        [&] {
          each([&](const std::uint8_t* p) {
            for (std::size_t x = 0; x < alpha_.size(); ++x, p += 4)
              std::copy_n(p, 3, rgb_.begin() + 3 * static_cast<std::ptrdiff_t>(x));
            colour_->row(rgb_.data());
          });
        },
        [&] {
          each([&](const std::uint8_t* p) {
            for (std::size_t x = 0; x < alpha_.size(); ++x) alpha_[x] = p[4 * x + 3];
            opacity_->row(alpha_.data());
          });
        });
  }

  void finish() {
    png = whole_.finish();
    if (!colour_) return;
    rgb_ = colour_->finish();
    alpha_ = opacity_->finish();
  }

  std::vector<std::uint8_t> png;  // as it is in the SVG
  // For a PDF, empty without opacity.
  std::vector<std::uint8_t> take_colour() { return std::move(rgb_); }
  std::vector<std::uint8_t> take_opacity() { return std::move(alpha_); }

 private:
  int width() const { return box_.right - box_.left; }
  int height() const { return box_.bottom - box_.top; }
  const PixelBox box_;
  const int channels_;
  PngWriter whole_;
  std::optional<PngWriter> colour_, opacity_;
  std::vector<std::uint8_t> rgb_, alpha_;  // a row each; after finish() the whole files
};

// Lays a row of straight RGBA on white, as RGB.
void on_white(const std::vector<std::uint8_t>& rgba, std::vector<std::uint8_t>& rgb) {
  rgb.resize(rgba.size() / 4 * 3);
  std::uint8_t* out = rgb.data();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = rgba[i + 3];
      *out++ = static_cast<std::uint8_t>((rgba[i + k] * a + 255 * (255 - a) + 127) / 255);
    }
}

// print.png: rows of ink as they are printed, with the marks over them.
class WholePng {
 public:
  WholePng(const Layer& layer, const Marks& marks, const PrintFormat& format, int channels)
      : marks_(marks),
        grid_(format.grid),
        channels_(channels),
        mirrored_(layer.mirrored()),
        opaque_(channels == 4 && format.settings.print.background == Background::white),
        row_(static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(channels)),
        png_(grid_.width, grid_.height, opaque_ ? 3 : channels, format.settings.print.dpi,
             channels == 4 ? format.profile.icc() : std::span<const std::uint8_t>()) {}

  // Rows [top, bottom) before any mirroring.
  void rows(int top, int bottom, const std::uint8_t* ink) {
    std::vector<std::uint8_t> marked;
    if (!marks_.marks.empty()) marked = draw_marks(marks_, grid_, top, bottom - top);
    for (int y = top; y < bottom; ++y) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y - top) * grid_.width;
      std::copy_n(ink + at * channels_, row_.size(), row_.begin());
      if (mirrored_) reverse(row_, channels_);
      if (!marked.empty()) lay_over(marked.data() + at, grid_.width, channels_, row_.data());
      if (opaque_) on_white(row_, rgb_);
      png_.row(opaque_ ? rgb_.data() : row_.data());
    }
  }
  std::vector<std::uint8_t> finish() { return png_.finish(); }

 private:
  const Marks& marks_;
  const PrintGrid grid_;
  const int channels_;
  const bool mirrored_, opaque_;
  std::vector<std::uint8_t> row_, rgb_;
  PngWriter png_;
};

// Makes the rows band by band; the files of a band are packed while the next band is made. `picture`: none for vectors.
Result<void> pack_rows(const RowSource& source, const PrintFormat& format, WholePng& whole,
                       std::optional<PictureFiles>& picture, const Context& context) {
  const PrintGrid& grid = format.grid;
  const int band = source.band_rows();
  std::vector<std::uint8_t> ink, next;
  for (int top = 0; top < grid.height + band; top += band) {
    VACUFORM_CHECK(context.step(Stage::printing, std::min(1.0, static_cast<double>(top) / grid.height)));
    const int before = top - band, end = std::min(top, grid.height);
    together(
        [&] {
          if (top >= grid.height) return;
          next = source.rows(top, std::min(top + band, grid.height));
          if (source.channels() == 4) format.profile.convert(next);
        },
        [&] {
          if (before >= 0) whole.rows(before, end, ink.data());
        },
        [&] {
          if (before >= 0 && picture) picture->rows(before, end, grid.width, ink.data());
        });
    ink.swap(next);
  }
  return {};
}

}  // namespace

Result<PrintedLayer> PrintedLayer::make(const Layer& layer, const Marks& marks, const PrintFormat& format,
                                        const Context& context) {
  const std::unique_ptr<RowSource> source = layer.source->printed(format.grid);
  const VectorPrint* const vectors = layer.source->vectors();
  const int channels = source->channels();
  WholePng whole(layer, marks, format, channels);
  std::optional<PictureFiles> picture;
  if (!vectors)
    picture.emplace(source->box(), channels, format.settings.print.dpi,
                    channels == 4 ? format.profile.icc() : std::span<const std::uint8_t>());
  VACUFORM_CHECK(pack_rows(*source, format, whole, picture, context));

  const SheetSettings& sheet = format.settings.sheet;
  PrintedLayer out({layer.name,
                    {{sheet.width_mm, sheet.height_mm}, layer.mirrored(), format.label, marks},
                    {.vectors = vectors}});
  PageContent in_svg{.vectors = vectors};
  if (picture) {
    picture->finish();
    out.whole_ = std::move(picture->png);
    in_svg.picture = placed_on_page(source->box(), format.grid, out.whole_);
    out.colour_ = picture->take_colour();
    out.opacity_ = picture->take_opacity();
    out.page.shown.picture =
        placed_on_page(source->box(), format.grid, channels == 4 ? out.colour_ : out.whole_);
    out.page.shown.opacity = out.opacity_;
  }
  together([&] { out.png = whole.finish(); }, [&] { out.svg = make_svg(out.page.page, in_svg); });
  return out;
}

}  // namespace vacuform
