#include "worker/colour/texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
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
  static constexpr std::uint32_t whole = 65535;  // linear light of white, in whole numbers
  static constexpr int step_bits = 2;            // 16,384 steps
  std::array<float, 256> linear;
  std::array<std::uint32_t, 256> linear16;
  std::array<std::uint8_t, (whole >> step_bits) + 1> encoded;
  Curve8() {
    for (std::size_t i = 0; i < 256; ++i) {
      linear[i] = linear_from_srgb(static_cast<float>(i) / 255);
      linear16[i] = static_cast<std::uint32_t>(std::lround(linear[i] * static_cast<float>(whole)));
    }
    for (std::size_t i = 0; i < encoded.size(); ++i)
      encoded[i] = static_cast<std::uint8_t>(std::lround(
          255 * srgb_from_linear((static_cast<float>(i) + 0.5f) / static_cast<float>(encoded.size()))));
  }
  std::uint8_t encode(std::uint32_t linear_light) const { return encoded[linear_light >> step_bits]; }
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
    for (int y = first; y < last; ++y) {
      const int below = std::min(2 * y + 1, fine.height - 1);
      const std::uint8_t *upper = fine.row(2 * y), *lower = fine.row(below);
      std::uint8_t* out = coarse.row(y);
      for (int x = 0; x < coarse.width; ++x, out += 4) {
        // A row or column at an odd border counts twice, which leaves the mean as it is.
        const int left = 4 * (2 * x), right = 4 * std::min(2 * x + 1, fine.width - 1);
        const std::array<const std::uint8_t*, 4> four{upper + left, upper + right, lower + left,
                                                      lower + right};
        const std::uint32_t weight = four[0][3] + four[1][3] + four[2][3] + four[3][3];
        const bool alike = weight == 0 || weight == 4 * 255;  // the texels count equally
        for (std::size_t k = 0; k < 3; ++k) {
          std::uint32_t sum = 0;
          for (const std::uint8_t* p : four) sum += (alike ? 1 : p[3]) * curve.linear16[p[k]];
          out[k] = curve.encode(alike ? sum / 4 : sum / weight);
        }
        out[3] = static_cast<std::uint8_t>((weight + 3) / 4);
      }
    }
  });
  return coarse;
}

void Texture::continue_islands(Level& level) {
  const Curve8& curve = curve8();
  constexpr int shown = 128, most_apart = Curve8::whole / 8;
  struct Continued {
    int x;
    std::array<std::uint8_t, 3> rgb;
  };
  std::vector<std::vector<Continued>> of_row(static_cast<std::size_t>(level.height));
  const auto texel = [&](int x, int y) -> const std::uint8_t* {
    if (x < 0 || y < 0 || x >= level.width || y >= level.height) return nullptr;
    const std::uint8_t* p = level.row(y) + 4 * std::ptrdiff_t{x};
    return p[3] >= shown ? p : nullptr;
  };
  const auto continued = [&](int x, int y) -> std::optional<Continued> {
    std::array<int, 3> sum{}, least, most;
    least.fill(Curve8::whole), most.fill(0);
    int count = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const std::uint8_t* const beside = texel(x + i, y + j);
        if (!beside) continue;
        const std::uint8_t* const beyond = texel(x + 2 * i, y + 2 * j);
        for (std::size_t k = 0; k < 3; ++k) {
          const int near = static_cast<int>(curve.linear16[beside[k]]);
          const int value = beyond ? 2 * near - static_cast<int>(curve.linear16[beyond[k]]) : near;
          sum[k] += value, least[k] = std::min(least[k], value), most[k] = std::max(most[k], value);
        }
        ++count;
      }
    if (count == 0) return std::nullopt;
    Continued out{x, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      if (most[k] - least[k] > most_apart) return std::nullopt;
      out.rgb[k] = curve.encode(static_cast<std::uint32_t>(std::clamp(sum[k] / count, 0, 65535)));
    }
    return out;
  };
  in_parallel(0, level.height, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      // Most texels are inside of an island or far from all.
      const std::uint8_t* const rows[] = {level.row(std::max(y - 1, 0)), level.row(y),
                                          level.row(std::min(y + 1, level.height - 1))};
      const auto above_and_below = [&](int x) {
        const std::ptrdiff_t at = 4 * std::ptrdiff_t{std::clamp(x, 0, level.width - 1)} + 3;
        return rows[0][at] | rows[1][at] | rows[2][at];
      };
      int before = above_and_below(-1), here = above_and_below(0);
      for (int x = 0; x < level.width; ++x) {
        const int after = above_and_below(x + 1);
        if ((before | here | after) != 0 && rows[1][4 * std::ptrdiff_t{x} + 3] == 0)
          if (const auto found = continued(x, y)) of_row[y].push_back(*found);
        before = here, here = after;
      }
    }
  });
  for (int y = 0; y < level.height; ++y)
    for (const auto& [x, rgb] : of_row[y]) {
      std::uint8_t* p = level.row(y) + 4 * std::ptrdiff_t{x};
      std::copy(rgb.begin(), rgb.end(), p);
      p[3] = 255;
    }
}

void Texture::build() {
  if (!marked_ || all_shown_) {
    auto& rgba = levels_.front().rgba;
    for (std::size_t i = 3; i < rgba.size(); i += 4) rgba[i] = 255;
  }
  while (std::max(levels_.back().width, levels_.back().height) > 1) levels_.push_back(halve(levels_.back()));
  if (marked_ && !all_shown_)
    for (Level& level : levels_) continue_islands(level);
}

Footprint Texture::footprint(const Vector2d& a, const Vector2d& b) const {
  constexpr int most_probes = 8;
  const Vector2d size(levels_[0].width, levels_[0].height);
  const Vector2d x = a.cwiseProduct(size), y = b.cwiseProduct(size);
  // The ellipse of the parallelogram: its axes are the singular values of (x y).
  const double p = x.x() * x.x() + y.x() * y.x(), q = x.y() * x.y() + y.y() * y.y(),
               r = x.x() * x.y() + y.x() * y.y();
  const double half = (p - q) / 2, root = std::sqrt(half * half + r * r);
  const double major = std::sqrt((p + q) / 2 + root), minor = std::sqrt(std::max((p + q) / 2 - root, 0.0));
  if (!std::isfinite(major)) return {};
  Footprint out;
  out.probes = static_cast<int>(
      std::clamp(std::ceil(major / std::max(minor, 1.0) - 0.01), 1.0, static_cast<double>(most_probes)));
  const double step = major / out.probes;
  if (out.probes > 1) {
    const Vector2d along = half > 0 ? Vector2d(root + half, r) : Vector2d(r, root - half);
    out.step = step * along.normalized().cwiseQuotient(size);
  }
  // A texel of side t seen through bilinear interpolation has the variance of a box of side sqrt(3) t.
  const double side = std::max(minor, step) / std::numbers::sqrt3;
  out.level = side > 1 ? std::min(std::log2(side), static_cast<double>(levels_.size() - 1)) : 0;
  return out;
}

inline Vector4f Texture::mean(const Level& level, double x, double y, Wrap across, Wrap down, bool all) {
  const std::array<float, 256>& linear = curve8().linear;
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const float fx = static_cast<float>(x - 0.5 - left), fy = static_cast<float>(y - 0.5 - top);
  const auto i = static_cast<std::int64_t>(left), j = static_cast<std::int64_t>(top);
  const std::uint8_t *upper, *lower;  // the left texels of the four
  std::ptrdiff_t right = 4;           // from there to the others
  if (i >= 0 && j >= 0 && i + 1 < level.width && j + 1 < level.height) {
    upper = level.row(static_cast<int>(j)) + 4 * i;
    lower = upper + 4 * std::ptrdiff_t{level.width};
  } else {
    const std::ptrdiff_t column = 4 * std::ptrdiff_t{wrapped(i, level.width, across)};
    right = 4 * std::ptrdiff_t{wrapped(i + 1, level.width, across)} - column;
    upper = level.row(wrapped(j, level.height, down)) + column;
    lower = level.row(wrapped(j + 1, level.height, down)) + column;
  }
  const std::array<const std::uint8_t*, 4> four{upper, upper + right, lower, lower + right};
  std::array<float, 4> share{(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  if (!all && (four[0][3] & four[1][3] & four[2][3] & four[3][3]) != 255)
    for (std::size_t k = 0; k < 4; ++k) share[k] *= static_cast<float>(four[k][3]) / 255;
  const auto sum = [&](auto&& value) {
    return (share[0] * value(four[0]) + share[1] * value(four[1])) +
           (share[2] * value(four[2]) + share[3] * value(four[3]));
  };
  return {sum([&](const std::uint8_t* p) { return linear[p[0]]; }),
          sum([&](const std::uint8_t* p) { return linear[p[1]]; }),
          sum([&](const std::uint8_t* p) { return linear[p[2]]; }),
          sum([](const std::uint8_t*) { return 1.0f; })};
}

Vector3f Texture::sample(const Vector2d& uv, const Footprint& footprint, Wrap across, Wrap down) const {
  const int low = static_cast<int>(footprint.level);
  const float blend = static_cast<float>(footprint.level - low);
  const Level &fine = levels_[low],
              &coarse = levels_[std::min(static_cast<std::size_t>(low) + 1, levels_.size() - 1)];
  const double shrink = 1.0 / static_cast<double>(std::int64_t{1} << low);
  const Vector2d size(levels_[0].width, levels_[0].height);
  constexpr float next_to_nothing = 1e-3f;
  Vector4f sum = Vector4f::Zero();
  for (const bool all : {false, true}) {
    for (int k = 0; k < footprint.probes; ++k) {
      const Vector2d at = (uv + (k + 0.5 - 0.5 * footprint.probes) * footprint.step).cwiseProduct(size);
      sum += (1 - blend) * mean(fine, at.x() * shrink, at.y() * shrink, across, down, all);
      if (blend > 0) sum += blend * mean(coarse, at.x() * shrink / 2, at.y() * shrink / 2, across, down, all);
    }
    if (sum.w() > next_to_nothing) break;
    sum.setZero();
  }
  return sum.head<3>() / sum.w();
}

}  // namespace vacuform
