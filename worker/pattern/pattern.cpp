// The pyramid follows L. Williams 1983, "Pyramidal parametrics". A footprint of diameter d has the variance of a
// box-filtered texel of side d / 2 seen through bilinear interpolation, so the level of that texel is sampled.
#include "worker/pattern/pattern.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/pattern/drawing_format.hpp"
#include "worker/pattern/dxf_drawing.hpp"
#include "worker/pattern/raster.hpp"
#include "worker/pattern/svg_size.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {
namespace {

struct Level {
  int width = 0, height = 0;
  std::vector<std::uint8_t> texels;
};

// Halves both sides. Beyond an odd edge there is no drawing and so no ink.
Level halve(const Level& fine, int channels) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
  coarse.texels.resize(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height) *
                       static_cast<std::size_t>(channels));
  const std::ptrdiff_t n = channels, row = n * fine.width;
  in_parallel(0, coarse.height, [&](int first, int last) {
    std::uint8_t* out = coarse.texels.data() + n * coarse.width * first;
    for (int y = first; y < last; ++y) {
      const std::uint8_t* const upper = fine.texels.data() + 2 * y * row;
      const std::ptrdiff_t below = 2 * y + 1 < fine.height ? row : 0;
      for (int x = 0; x < coarse.width; ++x) {
        const std::uint8_t* p = upper + 2 * x * n;
        const std::ptrdiff_t right = 2 * x + 1 < fine.width ? n : 0;
        for (int c = 0; c < channels; ++c, ++p) {
          int sum = 2 + p[0];
          if (right) sum += p[right];
          if (below) sum += p[below];
          if (right && below) sum += p[below + right];
          *out++ = static_cast<std::uint8_t>(sum / 4);
        }
      }
    }
  });
  return coarse;
}

// Adds weight times the bilinear value of the level at (x, y) in texels; the centre of the first texel is at (0.5,
// 0.5).
template <int channels>
inline void add_bilinear(const Level& level, double x, double y, float weight, float* out) {
  x -= 0.5;
  y -= 0.5;
  if (!(x > -1 && y > -1 && x < level.width && y < level.height)) return;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const float fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
  const std::array<float, 4> weights{(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const std::uint8_t* texel =
      level.texels.data() + (static_cast<std::ptrdiff_t>(j) * level.width + i) * channels;
  const std::ptrdiff_t below = static_cast<std::ptrdiff_t>(level.width) * channels;
  // Most of a drawing has no ink.
  if (channels == 1 && i >= 0 && j >= 0 && i + 1 < level.width && j + 1 < level.height &&
      (texel[0] | texel[1] | texel[below] | texel[below + 1]) == 0)
    return;
  const bool left = i >= 0, right = i + 1 < level.width, upper = j >= 0, lower = j + 1 < level.height;
  for (int c = 0; c < channels; ++c) {
    float sum = 0;
    if (left && upper) sum += weights[0] * texel[c];
    if (right && upper) sum += weights[1] * texel[channels + c];
    if (left && lower) sum += weights[2] * texel[below + c];
    if (right && lower) sum += weights[3] * texel[below + channels + c];
    out[c] += weight * sum;
  }
}

// From premultiplied red, green, blue and alpha.
Ink straight(const float* s) {
  if (!(s[3] > 0)) return {};
  return {std::min(1.0f, s[0] / s[3]), std::min(1.0f, s[1] / s[3]), std::min(1.0f, s[2] / s[3]), s[3]};
}

// Where a picture has its size from.
Result<std::string> size_of_pixels(const Raster& raster, const std::string& format,
                                   const std::string& file_name, const PatternSettings& settings,
                                   Eigen::Vector2d& size_mm) {
  // Pixels need not be square; a given width keeps their shape.
  const auto sized = [&](const Eigen::Vector2d& pixel) {
    return Eigen::Vector2d(raster.width * pixel.x(), raster.height * pixel.y());
  };
  const Eigen::Vector2d own = raster.pixel_mm.value_or(Eigen::Vector2d(1, 1));
  if (settings.width_mm) {
    size_mm = sized(own);
    size_mm *= *settings.width_mm / size_mm.x();
    return "a width of " + short_decimal(*settings.width_mm, 8) + " mm, as pattern.width_mm says";
  }
  if (settings.dpi) {
    size_mm = sized(own);
    size_mm *= raster.width * 25.4 / *settings.dpi / size_mm.x();
    return short_decimal(*settings.dpi) + " pixels an inch, as pattern.dpi says";
  }
  if (!raster.pixel_mm)
    return fail(Code::unusable_pattern, "the " + format + " does not say how large the drawing is", file_name,
                "give pattern.width_mm or pattern.dpi");
  const auto dpi_of = [](const Eigen::Vector2d& pixel) { return 25.4 / pixel.x(); };
  if (raster.exif_pixel_mm) {
    // JFIF has whole numbers only.
    constexpr double rounding = 0.01;
    const Eigen::Vector2d& other = *raster.exif_pixel_mm;
    if (((own - other).array().abs() > rounding * own.array()).any()) {
      std::vector<Proposal> proposals;
      for (const auto& [pixel, who] :
           {std::pair(own, ", as its JFIF data says"), {other, ", as its Exif data says"}}) {
        const Eigen::Vector2d mm = sized(pixel);
        proposals.push_back({{{"pattern.dpi", std::round(1000 * dpi_of(pixel)) / 1000}},
                             decimal(mm.x(), 1) + " x " + decimal(mm.y(), 1) + " mm" + who});
      }
      return fail(Code::unusable_pattern,
                  "the JPEG has " + short_decimal(dpi_of(own)) + " pixels an inch by its JFIF data and " +
                      short_decimal(dpi_of(other)) + " by its Exif data",
                  file_name, "say how large it is", std::move(proposals), "give pattern.width_mm");
    }
  }
  size_mm = sized(own);
  return short_decimal(dpi_of(own)) + " pixels an inch, as the file says";
}

Result<void> check_size(const Eigen::Vector2d& mm, const std::string& file_name) {
  if (mm.minCoeff() >= 0.1 && mm.maxCoeff() <= 5000) return {};
  return fail(Code::unusable_pattern,
              "the drawing would be " + decimal(mm.x(), 0) + " x " + decimal(mm.y(), 0) + " mm", file_name,
              "give pattern.width_mm");
}

// Decodes with one channel if that can hold the drawing, otherwise with four.
template <class Decode>
Result<Raster> decode(Decode&& with_channels) {
  Result<Raster> raster = with_channels(1);
  if (raster && raster->needs_colour) raster = with_channels(4);
  return raster;
}

}  // namespace

struct Pattern::Picture {
  int channels = 1;
  std::vector<Level> levels;
  Eigen::Vector2d size_mm;
  Eigen::Vector2d texel_mm{0, 0};  // of level 0
  double texel_side_mm = 0;        // of a square of its area
  std::string format, size_from, svg;
  double ink_mm2 = 0;
  std::vector<Warning> warnings;

  void build(Raster raster) {
    channels = raster.channels;
    levels.push_back({raster.width, raster.height, std::move(raster.pixels)});
    while (levels.back().width > 1 || levels.back().height > 1)
      levels.push_back(halve(levels.back(), channels));
    texel_mm = {size_mm.x() / levels.front().width, size_mm.y() / levels.front().height};
    texel_side_mm = std::sqrt(texel_mm.prod());

    double sum = 0;
    const auto& texels = levels.front().texels;
    if (channels == 1) {
      std::uint64_t total = 0;
      for (const std::uint8_t v : texels) total += v;
      sum = static_cast<double>(total);
    } else {
      std::array<std::uint64_t, 4> total{};
      for (std::size_t i = 0; i < texels.size(); ++i) total[i % 4] += texels[i];
      sum = static_cast<double>(total[3]) -
            (0.2126 * static_cast<double>(total[0]) + 0.7152 * static_cast<double>(total[1]) +
             0.0722 * static_cast<double>(total[2]));
    }
    ink_mm2 = sum / 255 * texel_mm.prod();
  }

  template <int n>
  void line(const Eigen::Vector2d& start, const Eigen::Vector2d& step, int count, double blur_mm,
            float* out) const {
    const Eigen::Vector2d& texel = texel_mm;
    const double side = blur_mm / (2 * texel_side_mm);  // of the wanted texel, in texels of level 0
    const double depth = side > 1 ? std::min(std::log2(side), static_cast<double>(levels.size() - 1)) : 0;
    const int low = static_cast<int>(depth);
    const float blend = static_cast<float>(depth - low);
    // v is up and rows go down.
    const Eigen::Vector2d at(start.x() / texel.x() + 0.5 * levels.front().width,
                             0.5 * levels.front().height - start.y() / texel.y());
    const Eigen::Vector2d move(step.x() / texel.x(), -step.y() / texel.y());
    std::fill_n(out, static_cast<std::ptrdiff_t>(n) * count, 0.0f);
    for (int l = low; l <= low + (blend > 0 ? 1 : 0); ++l) {
      const Level& level = levels[l];
      const double shrink = 1.0 / static_cast<double>(std::int64_t{1} << l);
      const float weight = (l == low ? 1 - blend : blend) / 255;
      const Eigen::Vector2d a = at * shrink, d = move * shrink;
      for (int k = 0; k < count; ++k)
        add_bilinear<n>(level, a.x() + k * d.x(), a.y() + k * d.y(), weight,
                        out + static_cast<std::ptrdiff_t>(n) * k);
    }
  }
};

Pattern::Pattern(std::shared_ptr<const Picture> picture) : picture_(std::move(picture)) {}
Pattern::~Pattern() = default;
Pattern::Pattern(Pattern&&) noexcept = default;
Pattern& Pattern::operator=(Pattern&&) noexcept = default;

Result<Pattern> Pattern::read(std::span<const std::uint8_t> bytes, const std::string& file_name,
                              const PatternSettings& settings, int dpi) {
  auto picture = std::make_shared<Picture>();
  std::optional<Raster> decoded;
  double wanted_dpi = dpi * settings.scale;  // of the drawing, so that the print shows all that it can

  switch (const DrawingFormat format = drawing_format(bytes)) {
    case DrawingFormat::png:
    case DrawingFormat::jpeg: {
      const bool png = format == DrawingFormat::png;
      picture->format = png ? "PNG" : "JPEG";
      VACUFORM_TRY(raster, decode([&](int channels) {
                     const RasterUse use{.channels = channels};
                     return png ? read_png(bytes, file_name, use) : read_jpeg(bytes, file_name, use);
                   }));
      VACUFORM_TRY(size_from, size_of_pixels(raster, picture->format, file_name, settings, picture->size_mm));
      picture->size_from = std::move(size_from);
      VACUFORM_CHECK(check_size(picture->size_mm, file_name));
      decoded = std::move(raster);
      break;
    }
    case DrawingFormat::dxf:
    case DrawingFormat::svg: {
      SizedSvg sized;
      if (format == DrawingFormat::svg) {
        picture->format = "SVG";
        VACUFORM_TRY(text, svg_text(bytes, file_name));
        VACUFORM_CHECK(check_svg(text, file_name));
        VACUFORM_TRY(in_mm, size_svg(std::move(text), file_name, settings));
        sized = std::move(in_mm);
      } else {
        picture->format = "DXF";
        VACUFORM_TRY(in_mm, dxf_drawing({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                                        file_name, settings));
        sized = std::move(in_mm);
      }
      VACUFORM_TRY(work, check_svg(sized.text, file_name));
      picture->size_mm = sized.size_mm;
      picture->size_from = std::move(sized.size_from);
      picture->warnings = std::move(sized.warnings);
      picture->svg = std::move(sized.text);
      VACUFORM_CHECK(check_size(picture->size_mm, file_name));
      // Finer than the print by the number of samples in each of its pixels.
      const double fine = std::max(2 * wanted_dpi, 300.0);
      const double pixels = (picture->size_mm / 25.4 * fine).prod();
      const double wanted = std::min(pixels, 0.98 * static_cast<double>(largest_raster));
      VACUFORM_TRY(affordable, affordable_pixels(work, wanted, file_name));
      const double draw_dpi = fine * std::min(1.0, std::sqrt(affordable / pixels));
      const auto side = [&](double mm) { return std::clamp(std::ceil(mm / 25.4 * draw_dpi), 1.0, 32000.0); };
      const int width = static_cast<int>(side(picture->size_mm.x())),
                height = static_cast<int>(side(picture->size_mm.y()));
      VACUFORM_TRY(raster, decode([&](int channels) {
                     return draw_svg(picture->svg, file_name, width, height, channels);
                   }));
      decoded = std::move(raster);
      break;
    }
    case DrawingFormat::other:
      return unread_format(bytes, file_name);
  }

  picture->build(std::move(*decoded));
  if (!(picture->ink_mm2 > 0))
    return fail(Code::unusable_pattern, "the drawing is empty: all of it is white or transparent", file_name,
                "give a drawing with ink in it");
  const double has_dpi = 25.4 / picture->texel_mm.maxCoeff();
  // A print that is finer than its drawing looks the same until the pixels become visible.
  if (has_dpi < (!picture->svg.empty() ? 0.9 * wanted_dpi : std::min(150.0, 0.5 * wanted_dpi)))
    picture->warnings.push_back({"pattern-coarse",
                                 "The drawing has " + decimal(has_dpi, 0) +
                                     " pixels an inch where the print could show " + decimal(wanted_dpi, 0) +
                                     ": its edges will look soft.",
                                 {},
                                 Warning::Figure{has_dpi, "1/in", wanted_dpi}});
  return Pattern(std::move(picture));
}

Pattern Pattern::of_picture(const Eigen::Vector2i& size_pixels, std::vector<std::uint8_t> premultiplied,
                            const Eigen::Vector2d& size_mm, std::string format) {
  auto picture = std::make_shared<Picture>();
  picture->format = std::move(format);
  picture->size_mm = size_mm;
  Raster raster;
  raster.width = size_pixels.x(), raster.height = size_pixels.y(), raster.channels = 4;
  raster.pixels = std::move(premultiplied);
  picture->build(std::move(raster));
  return Pattern(std::move(picture));
}

Eigen::Vector2d Pattern::size_mm() const { return picture_->size_mm; }
Eigen::Vector2i Pattern::size_pixels() const {
  return {picture_->levels.front().width, picture_->levels.front().height};
}
bool Pattern::grayscale() const { return picture_->channels == 1; }
const std::string& Pattern::format() const { return picture_->format; }
const std::string& Pattern::size_from() const { return picture_->size_from; }
const std::string& Pattern::svg() const { return picture_->svg; }
double Pattern::ink_mm2() const { return picture_->ink_mm2; }
const std::vector<Warning>& Pattern::warnings() const { return picture_->warnings; }

void Pattern::sample_line(const Eigen::Vector2d& start, const Eigen::Vector2d& step, int count,
                          double blur_mm, float* out) const {
  if (picture_->channels == 1)
    picture_->line<1>(start, step, count, blur_mm, out);
  else
    picture_->line<4>(start, step, count, blur_mm, out);
}

Ink Pattern::sample(const Eigen::Vector2d& uv, double blur_mm) const {
  float s[4] = {};
  sample_line(uv, Eigen::Vector2d::Zero(), 1, blur_mm, s);
  return picture_->channels == 1 ? Ink{0, 0, 0, s[0]} : straight(s);
}

void Pattern::sample_line(const Eigen::Vector2d& start, const Eigen::Vector2d& step, double blur_mm,
                          std::span<Ink> out) const {
  const auto channels = static_cast<std::size_t>(picture_->channels);
  std::vector<float> values(channels * out.size());
  sample_line(start, step, static_cast<int>(out.size()), blur_mm, values.data());
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = channels == 1 ? Ink{0, 0, 0, values[k]} : straight(&values[4 * k]);
}

}  // namespace vacuform
