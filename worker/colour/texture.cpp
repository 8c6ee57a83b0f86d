#include "worker/colour/texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "worker/pattern/raster.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/scan_lines.hpp"

namespace vacuform {

using Eigen::Vector2d;
using Eigen::Vector3f;
using Eigen::Vector4f;

namespace {

// Linear light of each encoded value, and the encoded value at the middle of each step of linear light.
struct Curve8 {
  static constexpr int steps = 1 << 14;
  std::array<float, 256> linear;
  std::vector<std::uint8_t> encoded;
  Curve8() : encoded(steps + 1) {
    for (std::size_t i = 0; i < 256; ++i) linear[i] = linear_from_srgb(static_cast<float>(i) / 255);
    for (int i = 0; i <= steps; ++i)
      encoded[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(
          255 *
          srgb_from_linear(std::min(1.0f, (static_cast<float>(i) + 0.5f) / static_cast<float>(steps)))));
  }
  std::uint8_t encode(float x) const {
    return encoded[static_cast<std::size_t>(std::clamp(x, 0.0f, 1.0f) * steps)];
  }
};
const Curve8& curve8() {
  static const Curve8 curve;
  return curve;
}

// Texel i of a row of n, also outside of the row.
int wrapped(std::int64_t i, int n, Wrap wrap) {
  if (i >= 0 && i < n) return static_cast<int>(i);
  if (wrap == Wrap::clamp) return i < 0 ? 0 : n - 1;
  const std::int64_t period = wrap == Wrap::mirror ? 2 * std::int64_t{n} : n;
  const std::int64_t at = ((i % period) + period) % period;
  return static_cast<int>(at < n ? at : period - 1 - at);
}

bool starts_with(std::span<const std::uint8_t> bytes, std::string_view magic, std::size_t from = 0) {
  return bytes.size() >= from + magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin() + static_cast<std::ptrdiff_t>(from),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

Result<Raster> unpack(const ScanImage& image, const std::string& where, const RasterUse& use) {
  const std::span<const std::uint8_t> bytes = image.bytes;
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n")) return read_png(bytes, where, use);
  if (starts_with(bytes, "\xff\xd8\xff")) return read_jpeg(bytes, where, use);
  const char* kind = starts_with(bytes, "RIFF") && starts_with(bytes, "WEBP", 8) ? "WebP"
                     : starts_with(bytes, "\xabKTX 20")                          ? "KTX2"
                                                                                 : nullptr;
  return fail(Code::unsupported_format,
              kind ? std::string("the texture is ") + kind : "the texture is neither PNG nor JPEG", where,
              "export the scan with PNG or JPEG textures");
}

}  // namespace

Result<Texture> Texture::read(const ScanImage& image, const std::string& where, std::int64_t most_pixels) {
  const std::string place = where + ", " + image.name;
  const RasterUse use{.texture = true, .most_pixels = most_pixels};
  VACUFORM_TRY(raster, unpack(image, place, use));
  if (std::max(raster.width, raster.height) > largest_texture_side)
    return too_many_pixels(raster.width, raster.height, place, use);
  for (std::size_t i = 3; i < raster.pixels.size(); i += 4) raster.pixels[i] = 0;
  Texture texture;
  texture.levels_.push_back({raster.width, raster.height, std::move(raster.pixels)});
  return texture;
}

void Texture::mark_shown(std::span<const Corners> triangles, Wrap across, Wrap down) {
  Level& level = levels_.front();
  const Vector2d size(level.width, level.height);
  marked_ = true;
  // Triangles that lie in one tile are moved to the image. A triangle that spans several tiles may show any texel.
  std::vector<std::array<Vector2d, 3>> moved;
  moved.reserve(triangles.size());
  for (const Corners& corners : triangles) {
    std::array<Vector2d, 3> at;
    for (int axis = 0; axis < 2; ++axis) {
      const Wrap wrap = axis == 0 ? across : down;
      const double n = size[axis];
      const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
      double tile = std::floor((static_cast<double>(low) + high) / 2);
      if (wrap == Wrap::clamp) tile = 0;
      const double slack = 1 / n;
      if (wrap != Wrap::clamp && (low < tile - slack || high > tile + 1 + slack)) all_shown_ = true;
      const bool reflected = wrap == Wrap::mirror && std::fmod(std::abs(tile), 2.0) == 1;
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = std::clamp(corners[k][axis] - tile, 0.0, 1.0);
        at[k][axis] = n * (reflected ? 1 - x : x);
      }
    }
    moved.push_back(at);
  }
  if (all_shown_) return;
  std::uint8_t* shown = level.rgba.data() + 3;
  const std::ptrdiff_t width = level.width;
  in_parallel(0, level.height, [&](int first, int last) {
    for (const auto& at : moved) {
      const double top = std::min({at[0].y(), at[1].y(), at[2].y()}),
                   bottom = std::max({at[0].y(), at[1].y(), at[2].y()});
      if (bottom < first - 1 || top > last + 1) continue;
      scan_triangle(at, level.width, first, last, [&](int row, int begin, int end) {
        for (std::ptrdiff_t i = row * width + begin; i < row * width + end; ++i) shown[4 * i] = 255;
      });
      // Small and thin triangles, down to single points of a palette, mark the texels below some of their points.
      const Vector2d middle = (at[0] + at[1] + at[2]) / 3;
      const bool small =
          std::abs((at[1] - at[0]).x() * (at[2] - at[0]).y() - (at[1] - at[0]).y() * (at[2] - at[0]).x()) < 2;
      for (const Vector2d& p : {middle, at[0], at[1], at[2]}) {
        const int x = std::clamp(static_cast<int>(p.x()), 0, level.width - 1),
                  y = std::clamp(static_cast<int>(p.y()), 0, level.height - 1);
        if (small && y >= first && y < last) shown[4 * (y * width + x)] = 255;
      }
    }
  });
}

Texture::Level Texture::halve(const Level& fine) {
  const Curve8& curve = curve8();
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
  coarse.rgba.resize(4 * static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
  in_parallel(0, coarse.height, [&](int first, int last) {
    std::uint8_t* out =
        &coarse.rgba[4 * static_cast<std::size_t>(first) * static_cast<std::size_t>(coarse.width)];
    for (int y = first; y < last; ++y)
      for (int x = 0; x < coarse.width; ++x, out += 4) {
        Vector3f shown = Vector3f::Zero(), all = Vector3f::Zero();
        int weight = 0, count = 0;
        for (int j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j)
          for (int i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i) {
            const std::uint8_t* p =
                &fine.rgba[4 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(fine.width) +
                                static_cast<std::size_t>(i))];
            const Vector3f linear(curve.linear[p[0]], curve.linear[p[1]], curve.linear[p[2]]);
            all += linear;
            shown += static_cast<float>(p[3]) * linear;
            weight += p[3];
            ++count;
          }
        const Vector3f mean = weight > 0 ? Vector3f(shown / static_cast<float>(weight))
                                         : Vector3f(all / static_cast<float>(count));
        for (int k = 0; k < 3; ++k) out[k] = curve.encode(mean[k]);
        out[3] = static_cast<std::uint8_t>((weight + count - 1) / count);
      }
  });
  return coarse;
}

void Texture::build() {
  if (!marked_ || all_shown_) {
    auto& rgba = levels_.front().rgba;
    for (std::size_t i = 3; i < rgba.size(); i += 4) rgba[i] = 255;
  }
  while (std::max(levels_.back().width, levels_.back().height) > 1) levels_.push_back(halve(levels_.back()));
}

Footprint Texture::footprint(const Vector2d& a, const Vector2d& b) const {
  constexpr int most_probes = 8;
  const Vector2d size(levels_[0].width, levels_[0].height);
  const Vector2d x = a.cwiseProduct(size), y = b.cwiseProduct(size);
  // The ellipse of the parallelogram: its axes are the singular values of (x y).
  const double p = x.x() * x.x() + y.x() * y.x(), q = x.y() * x.y() + y.y() * y.y(),
               r = x.x() * x.y() + y.x() * y.y();
  const double root = std::hypot((p - q) / 2, r);
  const double major = std::sqrt((p + q) / 2 + root), minor = std::sqrt(std::max((p + q) / 2 - root, 0.0));
  if (!std::isfinite(major)) return {};
  Footprint out;
  out.probes = static_cast<int>(
      std::clamp(std::ceil(major / std::max(minor, 1.0) - 0.01), 1.0, static_cast<double>(most_probes)));
  const double angle = std::atan2(2 * r, p - q) / 2, step = major / out.probes;
  if (out.probes > 1) out.step = step * Vector2d(std::cos(angle), std::sin(angle)).cwiseQuotient(size);
  // A texel of side t seen through bilinear interpolation has the variance of a box of side sqrt(3) t.
  const double side = std::max(minor, step) / std::numbers::sqrt3;
  out.level = side > 1 ? std::min(std::log2(side), static_cast<double>(levels_.size() - 1)) : 0;
  return out;
}

void Texture::add(const Level& level, double x, double y, float weight, Wrap across, Wrap down, bool all,
                  Vector4f& sum) {
  const Curve8& curve = curve8();
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const float fx = static_cast<float>(x - 0.5 - left), fy = static_cast<float>(y - 0.5 - top);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int column = wrapped(static_cast<std::int64_t>(left) + i, level.width, across),
                row = wrapped(static_cast<std::int64_t>(top) + j, level.height, down);
      const std::uint8_t* p =
          &level.rgba[4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(level.width) +
                           static_cast<std::size_t>(column))];
      const float share = weight * (i == 0 ? 1 - fx : fx) * (j == 0 ? 1 - fy : fy) *
                          (all ? 1.0f : static_cast<float>(p[3]) / 255);
      sum += share * Vector4f(curve.linear[p[0]], curve.linear[p[1]], curve.linear[p[2]], 1);
    }
}

Vector3f Texture::sample(const Vector2d& uv, const Footprint& footprint, Wrap across, Wrap down) const {
  const int low = static_cast<int>(footprint.level);
  const float blend = static_cast<float>(footprint.level - low);
  const Vector2d size(levels_[0].width, levels_[0].height);
  constexpr float next_to_nothing = 1e-3f;
  Vector4f sum = Vector4f::Zero();
  for (const bool all : {false, true}) {
    for (int k = 0; k < footprint.probes; ++k) {
      const Vector2d at = (uv + (k + 0.5 - 0.5 * footprint.probes) * footprint.step).cwiseProduct(size);
      for (int l = low; l <= low + (blend > 0 ? 1 : 0); ++l) {
        const double shrink = 1.0 / static_cast<double>(std::int64_t{1} << l);
        add(levels_[static_cast<std::size_t>(l)], at.x() * shrink, at.y() * shrink,
            l == low ? 1 - blend : blend, across, down, all, sum);
      }
    }
    if (sum.w() > next_to_nothing) break;
    sum.setZero();
  }
  return sum.head<3>() / sum.w();
}

}  // namespace vacuform
