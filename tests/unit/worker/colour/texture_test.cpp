#include "worker/colour/texture.hpp"

#include <gtest/gtest.h>

#include "tests/unit/fixtures/coloured_scans.hpp"

namespace vacuform {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

const Vector3f red(1, 0, 0), green(0, 1, 0), black(0, 0, 0), white(1, 1, 1);

Texture texture_of(int width, int height, const coloured::Paint& paint) {
  return *Texture::read({"image 0", coloured::png(width, height, paint)}, "a.glb", most_texture_pixels);
}

Vector3f seen(const Texture& texture, double u, double v, double side = 0, Wrap wrap = Wrap::repeat) {
  return texture.sample({u, v}, texture.footprint({side, 0}, {0, side}), wrap, wrap);
}

TEST(Texture, AveragesInLinearLight) {
  Texture checks = texture_of(64, 64, [](double u, double v) {
    return (static_cast<int>(64 * u) + static_cast<int>(64 * v)) % 2 == 0 ? white : black;
  });
  checks.build();
  EXPECT_LT((seen(checks, 0.5, 0.5, 0.5) - Vector3f(0.5f, 0.5f, 0.5f)).norm(), 0.01f);
  EXPECT_EQ(seen(checks, 0.5 / 64, 0.5 / 64), white);  // the middle of a texel is that texel
}

TEST(Texture, NeverShowsWhatLiesBetweenIslands) {
  Texture halves = texture_of(64, 64, [](double u, double) { return u < 0.5 ? red : green; });
  halves.mark_shown(
      std::vector<Texture::Corners>{
          {Eigen::Vector2f(0, 0), Eigen::Vector2f(0.5f, 0), Eigen::Vector2f(0, 1)},
          {Eigen::Vector2f(0.5f, 0), Eigen::Vector2f(0.5f, 1), Eigen::Vector2f(0, 1)}},
      Wrap::repeat, Wrap::repeat);
  halves.build();
  for (const double side : {0.0, 0.01, 0.05, 0.3})
    EXPECT_LT((seen(halves, 0.4999, 0.5, side) - red).norm(), 1e-5f) << side;
}

TEST(Texture, ShowsASinglePointOfAPalette) {
  Texture palette = texture_of(4, 1, [](double u, double) {
    return u < 0.25 ? red : u < 0.5 ? green : white;
  });
  const Eigen::Vector2f point(0.375f, 0.5f);
  palette.mark_shown(std::vector<Texture::Corners>{{point, point, point}}, Wrap::clamp, Wrap::clamp);
  palette.build();
  EXPECT_EQ(seen(palette, 0.375, 0.5, 0, Wrap::clamp), green);
}

TEST(Texture, RepeatsMirrorsAndEnds) {
  Texture columns =
      texture_of(4, 4, [](double u, double) { return Vector3f(u < 0.25 ? 1 : 0, u > 0.75 ? 1 : 0, 0); });
  columns.build();
  EXPECT_EQ(seen(columns, 1.125, 0.5, 0, Wrap::repeat), red);
  EXPECT_EQ(seen(columns, -0.125, 0.5, 0, Wrap::repeat), green);
  EXPECT_EQ(seen(columns, 1.125, 0.5, 0, Wrap::mirror), green);
  EXPECT_EQ(seen(columns, -0.125, 0.5, 0, Wrap::mirror), red);
  EXPECT_EQ(seen(columns, 2.125, 0.5, 0, Wrap::mirror), red);
  EXPECT_EQ(seen(columns, 7.0, 0.5, 0, Wrap::clamp), green);
  EXPECT_EQ(seen(columns, -1e6, 0.5, 0, Wrap::clamp), red);
}

TEST(Texture, BlursALongFootprintAlongItsLengthOnly) {
  Texture bands = texture_of(
      256, 256, [](double, double v) { return static_cast<int>(16 * v) % 2 == 0 ? white : black; });
  bands.build();
  // Sixteen texels long, one across: along the bands it sees one, across them it sees several.
  const Vector2d length(32.0 / 256, 0), width(0, 1.0 / 256);
  const auto along =
      bands.sample({0.5, 1.5 / 16}, bands.footprint(length, width), Wrap::repeat, Wrap::repeat);
  EXPECT_LT(along.norm(), 0.02f);
  const auto across = bands.sample({0.5, 1.5 / 16}, bands.footprint({0, 32.0 / 256}, {1.0 / 256, 0}),
                                   Wrap::repeat, Wrap::repeat);
  EXPECT_NEAR(across.x(), 0.5f, 0.05f);
}

struct BadImage {
  std::vector<std::uint8_t> bytes;
  Code code;
  const char* what;
};
void PrintTo(const BadImage& image, std::ostream* out) { *out << image.what; }

std::vector<std::uint8_t> lying_png(int at, std::uint8_t value) {
  auto bytes = coloured::png(8, 8, [](double, double) { return red; });
  bytes[static_cast<std::size_t>(at)] = value;
  return bytes;
}

class BadImages : public testing::TestWithParam<BadImage> {};

TEST_P(BadImages, AreRefusedWithTheirPlaceInTheScan) {
  const auto texture = Texture::read({"image 3", GetParam().bytes}, "a.glb", most_texture_pixels);
  ASSERT_FALSE(texture);
  EXPECT_EQ(texture.error().code, GetParam().code) << texture.error().text();
  EXPECT_NE(texture.error().text().find(GetParam().what), std::string::npos) << texture.error().text();
  EXPECT_EQ(texture.error().where, "a.glb, image 3");
  EXPECT_EQ(texture.error().text().find("drawing"), std::string::npos) << texture.error().text();
}

INSTANTIATE_TEST_SUITE_P(
    Colour, BadImages,
    testing::Values(BadImage{shapes::text_bytes("RIFF....WEBPVP8 "), Code::unsupported_format, "WebP"},
                    BadImage{shapes::text_bytes("\xabKTX 20\xbb\r\n"), Code::unsupported_format, "KTX2"},
                    BadImage{{}, Code::unsupported_format, "neither PNG nor JPEG"},
                    BadImage{lying_png(16, 0x7f), Code::too_large, "pixels"},      // the width
                    BadImage{lying_png(18, 0x40), Code::corrupt_file, "damaged"},  // 16,392 pixels wide
                    BadImage{shapes::text_bytes("\xff\xd8\xff\xe0"), Code::corrupt_file, "damaged"}));

TEST(Texture, RefusesTooManyPixels) {
  const auto bytes = coloured::png(64, 64, [](double, double) { return red; });
  const auto texture = Texture::read({"image 0", bytes}, "a.glb", 4095);
  ASSERT_FALSE(texture);
  EXPECT_EQ(texture.error().code, Code::too_large);
}

}  // namespace
}  // namespace vacuform
