#include "worker/pattern/pattern.hpp"

#include <glib.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>

#include "api/problem.hpp"
#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/ring_files.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

Result<Pattern> read(const Bytes& bytes, const std::string& name = "drawing",
                     std::optional<double> width_mm = {}, int dpi = 254) {
  PatternSettings settings;
  settings.width_mm = width_mm;
  return Pattern::read(bytes, name, settings, dpi);
}
Result<Pattern> read(const std::string& text, std::optional<double> width_mm = {}, int dpi = 254) {
  return read(bytes_of(text), "drawing.svg", width_mm, dpi);
}

std::string svg(const std::string& attributes, const std::string& body = "<rect width='10' height='10'/>") {
  return "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' " + attributes +
         ">" + body + "</svg>";
}

// Dark left half and a darker quadrant at the top right: every rotation and reflection gives a different picture.
int quadrants(int x, int y, int width, int height) { return 2 * x < width ? 200 : 2 * y < height ? 0 : 255; }

TEST(Pattern, ReadsThePhysicalSizeOfAnSvgInEveryAbsoluteUnit) {
  const std::pair<const char*, double> cases[] = {
      {"width='50mm' height='20mm'", 50},      {"width='5cm' height='2cm'", 50},
      {"width='2in' height='1in'", 50.8},      {"width='144pt' height='72pt'", 50.8},
      {"width='12pc' height='6pc'", 50.8},     {"width='200Q' height='80q'", 50},
      {"width='50MM' height='2Cm'", 50},       {"width='50mm' viewBox='0 0 10 5'", 50},
      {"height='25mm' viewBox='0 0 10 5'", 50}};
  for (const auto& [attributes, width] : cases) {
    const auto pattern = read(svg(attributes));
    ASSERT_TRUE(pattern) << attributes << ": " << pattern.error().text();
    EXPECT_NEAR(pattern->size_mm().x(), width, 1e-9) << attributes;
    EXPECT_EQ(pattern->format(), "SVG");
  }
}

TEST(Pattern, AsksForTheWidthWhenTheFileDoesNotSayIt) {
  for (const auto& bytes :
       {bytes_of(svg("viewBox='0 0 20 10'")), bytes_of(svg("width='100%' height='100%' viewBox='0 0 20 10'")),
        png(1, 1, 8, 0, {{0}})}) {
    const auto pattern = read(bytes, "p");
    ASSERT_FALSE(pattern);
    EXPECT_EQ(pattern.error().code, Code::unusable_pattern);
    EXPECT_NE(pattern.error().fix.find("pattern.width_mm"), std::string::npos);
    EXPECT_NE(pattern.error().fix.find("pattern.dpi"), std::string::npos);
  }
  const auto given = read(svg("viewBox='0 0 20 10'"), 80);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->size_mm(), Vector2d(80, 40));
}

TEST(Pattern, MeasuresTheInkOfARing) {
  const auto ring = read(svg("width='60mm' height='60mm' viewBox='-30 -30 60 60'",
                             "<circle r='20' fill='none' stroke='#000' stroke-width='3'/>"));
  ASSERT_TRUE(ring);
  EXPECT_TRUE(ring->grayscale());
  EXPECT_NEAR(ring->ink_mm2(), 2 * M_PI * 20 * 3, 0.3);
  EXPECT_NEAR(ring->sample({20, 0}, 0.1).coverage(), 1, 1e-3);
  EXPECT_NEAR(ring->sample({0, -20}, 0.1).coverage(), 1, 1e-3);
  EXPECT_EQ(ring->sample({0, 0}, 0.1).a, 0);
}

TEST(Pattern, TellsColourFromGray) {
  EXPECT_TRUE(read(svg("width='9mm' height='9mm'", "<rect width='5' height='5' fill='#777' opacity='0.5'/>"))
                  ->grayscale());
  const auto red = read(
      svg("width='10mm' height='10mm' viewBox='0 0 10 10'", "<rect width='10' height='5' fill='#f00'/>"));
  ASSERT_TRUE(red);
  EXPECT_FALSE(red->grayscale());
  EXPECT_NEAR(red->ink_mm2(), 50 * (1 - 0.2126), 0.1);
  const Ink ink = red->sample({0, 2.5}, 0.1);  // v is up: the upper half is red
  EXPECT_NEAR(ink.r, 1, 1e-6);
  EXPECT_NEAR(ink.g, 0, 1e-6);
  EXPECT_NEAR(ink.a, 1, 1e-3);
  EXPECT_EQ(red->sample({0, -2.5}, 0.1).a, 0);
}

TEST(Pattern, WhiteIsNoInkOpaqueOrNot) {
  const auto paper = read(gray_png(100, 100, 10000, [](int x, int) { return x < 25 ? 0 : 255; }));
  ASSERT_TRUE(paper);
  EXPECT_NEAR(paper->ink_mm2(), 25, 1e-9);
  EXPECT_EQ(paper->sample({3, 0}, 0.1).coverage(), 0);
  const auto blank = read(gray_png(10, 10, 10000, [](int, int) { return 255; }));
  ASSERT_FALSE(blank);
  EXPECT_EQ(blank.error().code, Code::unusable_pattern);
  EXPECT_EQ(blank.error().what, "the drawing is empty: all of it is white or transparent");
}

TEST(Pattern, ReadsEveryKindOfPng) {
  // The same picture, 2 x 2: black, white over middle gray, black half transparent.
  const Bytes resolution = phys(10000, 10000);
  const auto with = [&](Bytes extra) {
    extra.insert(extra.begin(), resolution.begin(), resolution.end());
    return extra;
  };
  Bytes palette, transparency, extra;
  put_chunk(palette, "PLTE", {0, 0, 0, 255, 255, 255, 128, 128, 128});
  put_chunk(transparency, "tRNS", {255, 255, 255});
  extra = palette;
  extra.insert(extra.end(), transparency.begin(), transparency.end());
  const std::pair<const char*, Bytes> files[] = {
      {"gray 8", png(2, 2, 8, 0, {{0, 255}, {128, 255}}, resolution)},
      {"gray 16", png(2, 2, 16, 0, {{0, 0, 255, 255}, {128, 128, 255, 255}}, resolution)},
      {"RGB 8", png(2, 2, 8, 2, {{0, 0, 0, 255, 255, 255}, {128, 128, 128, 255, 255, 255}}, resolution)},
      {"palette", png(2, 2, 8, 3, {{0, 1}, {2, 1}}, with(extra))},
      {"gray and alpha", png(2, 2, 8, 4, {{0, 255, 255, 255}, {0, 127, 0, 0}}, resolution)},
      {"RGBA 16", png(2, 2, 16, 6,
                      {{0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255},
                       {0, 0, 0, 0, 0, 0, 127, 127, 9, 9, 9, 9, 9, 9, 0, 0}},
                      resolution)}};
  for (const auto& [name, bytes] : files) {
    const auto pattern = read(bytes, name);
    ASSERT_TRUE(pattern) << name << ": " << pattern.error().text();
    EXPECT_TRUE(pattern->grayscale()) << name;
    EXPECT_EQ(pattern->size_mm(), Vector2d(0.2, 0.2)) << name;
    EXPECT_NEAR(pattern->ink_mm2(), 0.01 * (255 + 127) / 255, 1e-12) << name;
    EXPECT_NEAR(pattern->sample({-0.05, 0.05}, 0).coverage(), 1, 1e-6) << name;
  }
  const auto bits = read(png(8, 1, 1, 0, {{0b01111111}}, resolution));
  ASSERT_TRUE(bits);
  EXPECT_NEAR(bits->ink_mm2(), 0.01, 1e-12);
}

TEST(Pattern, KeepsPixelsThatAreNotSquare) {
  const auto pattern = read(png(2, 2, 8, 0, {{0, 0}, {0, 0}}, phys(1000, 500)));
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->size_mm(), Vector2d(2, 4));
  EXPECT_EQ(read(png(2, 2, 8, 0, {{0, 0}, {0, 0}}, phys(1000, 500)), "p", 10)->size_mm(), Vector2d(10, 20));
}

TEST(Pattern, ReadsJpegAndItsDensity) {
  const auto gray = read(jpeg(64, 32, 1, [](int x, int, int) { return x < 32 ? 0 : 255; }));
  ASSERT_TRUE(gray) << gray.error().text();
  EXPECT_EQ(gray->format(), "JPEG");
  EXPECT_TRUE(gray->grayscale());
  EXPECT_NEAR(gray->size_mm().x(), 6.4, 1e-9);
  EXPECT_NEAR(gray->ink_mm2(), 3.2 * 3.2, 0.05);
  const auto colour = read(jpeg(64, 32, 3, [](int, int, int c) { return c == 0 ? 255 : 0; }));
  ASSERT_TRUE(colour);
  EXPECT_FALSE(colour->grayscale());
  EXPECT_NEAR(colour->sample({0, 0}, 0.1).r, 1, 0.02);
}

TEST(Pattern, ReadsProgressiveJpegButNotThousandsOfScans) {
  Bytes bytes = jpeg(
      64, 32, 1, [](int x, int, int) { return x < 32 ? 0 : 255; }, 0, true);
  ASSERT_TRUE(read(bytes));
  EXPECT_NEAR(read(bytes)->ink_mm2(), 3.2 * 3.2, 0.05);
  // The last scan repeated many times; each copy would be decoded over the whole picture.
  const std::array<std::uint8_t, 2> start_of_scan{0xff, 0xda};
  const auto last = std::find_end(bytes.begin(), bytes.end(), start_of_scan.begin(), start_of_scan.end());
  const Bytes scan(last, bytes.end() - 2);
  for (int i = 0; i < 5000; ++i) bytes.insert(bytes.end() - 2, scan.begin(), scan.end());
  const auto pattern = read(bytes);
  ASSERT_FALSE(pattern);
  EXPECT_EQ(pattern.error().code, Code::corrupt_file);
}

TEST(Pattern, RefusesCmykByName) {
  const auto pattern = read(jpeg(16, 16, 4, [](int, int, int) { return 100; }), "coil.jpg");
  ASSERT_FALSE(pattern);
  EXPECT_EQ(pattern.error().code, Code::unsupported_format);
  EXPECT_EQ(pattern.error().text(), "the JPEG is in CMYK colours (coil.jpg); save it in RGB or grayscale");
}

TEST(Pattern, TurnsAJpegUprightByItsOrientation) {
  constexpr int w = 64, h = 32;
  // Where the upright picture's pixel (x, y) is stored, for each orientation of the Exif standard.
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const bool transposed = orientation >= 5;
    const auto stored = [&](int x, int y, int) {
      // From stored (x, y) to the upright picture of w x h.
      const int sw = transposed ? h : w, sh = transposed ? w : h;
      switch (orientation) {
        case 1:
          return quadrants(x, y, w, h);
        case 2:
          return quadrants(sw - 1 - x, y, w, h);
        case 3:
          return quadrants(sw - 1 - x, sh - 1 - y, w, h);
        case 4:
          return quadrants(x, sh - 1 - y, w, h);
        case 5:
          return quadrants(y, x, w, h);
        case 6:
          return quadrants(sh - 1 - y, x, w, h);
        case 7:
          return quadrants(sh - 1 - y, sw - 1 - x, w, h);
        default:
          return quadrants(y, sw - 1 - x, w, h);
      }
    };
    const auto pattern = read(jpeg(transposed ? h : w, transposed ? w : h, 1, stored, orientation));
    ASSERT_TRUE(pattern) << orientation;
    EXPECT_NEAR(pattern->size_mm().x(), 6.4, 1e-9) << orientation;
    EXPECT_NEAR(pattern->sample({-1.6, 0.8}, 0.5).coverage(), 55.0 / 255, 0.02) << orientation;
    EXPECT_NEAR(pattern->sample({-1.6, -0.8}, 0.5).coverage(), 55.0 / 255, 0.02) << orientation;
    EXPECT_NEAR(pattern->sample({1.6, 0.8}, 0.5).coverage(), 1, 0.02) << orientation;
    EXPECT_NEAR(pattern->sample({1.6, -0.8}, 0.5).coverage(), 0, 0.02) << orientation;
  }
}

TEST(Pattern, SamplesTheMeanOfItsFootprint) {
  // Lines of 1 pixel, half ink: from a distance, half coverage everywhere, at any position and blur.
  const auto lines = read(gray_png(512, 512, 10000, [](int x, int) { return x % 2 ? 0 : 255; }));
  ASSERT_TRUE(lines);
  for (const double blur : {0.8, 1.1, 3.0, 7.7})
    for (const double u : {0.0, 0.03, 1.234})
      EXPECT_NEAR(lines->sample({u, 0.017}, blur).coverage(), 0.5, 0.01) << blur;
  // Unblurred, it is exact at the pixels' centres and linear between them.
  EXPECT_NEAR(lines->sample({0.05, 0.05}, 0).coverage(), 0, 1e-6);
  EXPECT_NEAR(lines->sample({0.15, 0.05}, 0).coverage(), 1, 1e-6);
  EXPECT_NEAR(lines->sample({0.10, 0.05}, 0).coverage(), 0.5, 1e-6);
  // There is no ink off the drawing, and no sample at an invalid position.
  EXPECT_EQ(lines->sample({26, 0}, 0.1).a, 0);
  EXPECT_EQ(lines->sample({NAN, 0}, 0.1).a, 0);
  EXPECT_EQ(lines->sample({1e300, -1e300}, 1).a, 0);
}

TEST(Pattern, ALineOfSamplesIsTheSamplesOfALine) {
  const auto pattern =
      read(svg("width='40mm' height='40mm' viewBox='0 0 40 40'",
               "<circle cx='20' cy='20' r='12' fill='none' stroke='#05f' stroke-width='2'/>"));
  ASSERT_TRUE(pattern);
  float line[4 * 50];
  const Vector2d start(-15, 3), step(0.6, -0.1);
  pattern->sample_line(start, step, 50, 0.37, line);
  for (int k = 0; k < 50; ++k) {
    const Ink ink = pattern->sample(start + k * step, 0.37);
    EXPECT_FLOAT_EQ(line[4 * k + 3], ink.a);
    EXPECT_NEAR(line[4 * k + 2], ink.b * ink.a, 1e-6);
  }
  std::vector<Ink> inks(50);
  pattern->sample_line(start, step, 0.37, inks);
  for (int k = 0; k < 50; ++k) {
    const Ink ink = pattern->sample(start + k * step, 0.37);
    EXPECT_FLOAT_EQ(inks[static_cast<std::size_t>(k)].a, ink.a);
    EXPECT_FLOAT_EQ(inks[static_cast<std::size_t>(k)].b, ink.b);
  }
}

TEST(Pattern, TellsTheFormatByItsBytesAndNotByItsName) {
  const auto pattern = read(gray_png(4, 4, 1000, [](int, int) { return 0; }), "drawing.svg");
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->format(), "PNG");
  EXPECT_EQ(read(bytes_of("\xef\xbb\xbf<?xml version='1.0'?>" + svg("width='9mm' height='9mm'")), "x.png")
                ->format(),
            "SVG");
  EXPECT_EQ(read(bytes_of("\n  " + svg("width='9mm' height='9mm'")), "x.jpg")->format(), "SVG");
}

TEST(Pattern, WarnsWhenTheDrawingIsCoarse) {
  const auto coarse = read(gray_png(20, 20, 1000, [](int, int) { return 0; }), "p", {}, 300);
  ASSERT_TRUE(coarse);
  ASSERT_EQ(coarse->warnings().size(), 1u);
  EXPECT_EQ(coarse->warnings()[0].code, "pattern-coarse");
  EXPECT_EQ(coarse->warnings()[0].text,
            "The drawing has 25 pixels an inch where the print could show 300: its edges will look soft.");
  EXPECT_TRUE(read(gray_png(20, 20, 12000, [](int, int) { return 0; }), "p", {}, 300)->warnings().empty());
}

TEST(Pattern, AHugeDrawingIsDrawnAtTheLimitAndSaysSo) {
  const auto pattern = read(svg("width='400mm' height='400mm' viewBox='0 0 10 10'"), {}, 1200);
  ASSERT_TRUE(pattern);
  EXPECT_LE(pattern->size_pixels().cast<double>().prod(), 64e6);
  EXPECT_GE(pattern->size_pixels().cast<double>().prod(), 60e6);
  ASSERT_EQ(pattern->warnings().size(), 1u);
  EXPECT_EQ(pattern->warnings()[0].code, "pattern-coarse");
}

// One refusal per row: the bytes, the code and the message.
struct Refusal {
  const char* what;
  Bytes bytes;
  Code code;
  std::string message;
};

Bytes cut(Bytes bytes, double part) {
  bytes.resize(static_cast<std::size_t>(static_cast<double>(bytes.size()) * part));
  return bytes;
}

std::string holding(const std::string& type, const Bytes& picture) {
  gchar* text = g_base64_encode(picture.data(), picture.size());
  const std::string address = "data:" + type + ";base64," + text;
  g_free(text);
  return svg("width='20mm' height='10mm' viewBox='0 0 20 10'",
             "<image width='20' height='10' xlink:href='" + address + "'/>");
}

std::vector<Refusal> refusals() {
  const Bytes good_png = gray_png(200, 200, 10000, [](int x, int y) { return (x * y) % 251; });
  const Bytes good_jpeg = jpeg(200, 200, 3, [](int x, int y, int c) { return (x * y * (c + 1)) % 251; });
  Bytes broken_crc = good_png;
  broken_crc[chunk(good_png, "IDAT") + 100] ^= 0x55;
  Bytes nested = bytes_of("<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'>");
  for (int i = 0; i < 100'000; ++i) nested.insert(nested.end(), {'<', 'g', '>'});
  for (int i = 0; i < 100'000; ++i) nested.insert(nested.end(), {'<', '/', 'g', '>'});
  const Bytes end = bytes_of("</svg>");
  nested.insert(nested.end(), end.begin(), end.end());

  return {
      {"nothing",
       {},
       Code::unsupported_format,
       "the drawing is neither PNG, JPEG, SVG nor DXF (x); give a PNG, JPEG, SVG or DXF file"},
      {"text", bytes_of("hello"), Code::unsupported_format,
       "the drawing is neither PNG, JPEG, SVG nor DXF (x); give a PNG, JPEG, SVG or DXF file"},
      {"compressed SVG",
       {0x1f, 0x8b, 8, 0},
       Code::corrupt_file,
       "the packed file is damaged: it ends early (x); unpack the file, or export it again"},
      {"HTML that speaks of svg", bytes_of("<html><body>svg</body></html>"), Code::unsupported_format,
       "the drawing is XML, but not SVG (x); give a PNG, JPEG or SVG file"},
      {"PNG of 2^31 - 1 squared pixels", png(0x7fffffff, 0x7fffffff, 8, 0, {{0}}), Code::too_large,
       "the drawing has 2147483647 x 2147483647 pixels (x); give one of at most 64 million pixels, or an "
       "SVG"},
      {"PNG of 2^32 - 1 pixels", png(0xffffffff, 1, 8, 0, {{0}}), Code::corrupt_file,
       "the PNG is damaged: it has no size (x); export the drawing again"},
      {"PNG of no pixels", png(0, 5, 8, 0, {{0}}), Code::corrupt_file,
       "the PNG is damaged: it has no size (x); export the drawing again"},
      {"PNG whose pixels cannot be in the file", png(7000, 7000, 8, 6, {{0, 0, 0, 0}}), Code::corrupt_file,
       "the PNG is damaged: the file is too short for its size (x); export the drawing again"},
      {"PNG of its first bytes", {good_png.begin(), good_png.begin() + 4}, Code::unsupported_format, ""},
      {"PNG cut in its header",
       {good_png.begin(), good_png.begin() + 20},
       Code::corrupt_file,
       "the PNG is damaged: the file ends early (x); export the drawing again"},
      {"PNG cut in half", cut(good_png, 0.5), Code::corrupt_file,
       "the PNG is damaged: the file ends early (x); export the drawing again"},
      {"PNG without its end",
       {good_png.begin(), good_png.end() - 12},
       Code::corrupt_file,
       "the PNG is damaged: the file ends early (x); export the drawing again"},
      {"PNG with a broken checksum", broken_crc, Code::corrupt_file, ""},
      {"PNG of an impossible depth", png(4, 4, 3, 0, {{0, 0}}), Code::corrupt_file, ""},
      {"JPEG of its first bytes", cut(good_jpeg, 0.01), Code::corrupt_file, ""},
      {"JPEG cut in half", cut(good_jpeg, 0.5), Code::corrupt_file,
       "the JPEG is damaged: Premature end of JPEG file (x); export the drawing again"},
      {"SVG cut in half", cut(bytes_of(svg("width='9mm' height='9mm'")), 0.7), Code::corrupt_file, ""},
      {"SVG without a size", bytes_of(svg("")), Code::unusable_pattern,
       "the SVG has no size (x); give its svg element a width, height and viewBox"},
      {"SVG as large as a country", bytes_of(svg("width='1e9mm' height='1e9mm'")), Code::unusable_pattern,
       "the drawing would be 1000000000 x 1000000000 mm (x); give pattern.width_mm"},
      {"SVG with a picture elsewhere",
       bytes_of(svg("width='9mm' height='9mm'",
                    "<g><image width='5' height='5' xlink:href='file:///etc/hostname'/></g>")),
       Code::unusable_pattern,
       "the SVG refers to another file in its <image> element on line 1 (x); embed the picture in the "
       "drawing, or give the picture itself"},
      {"SVG that uses a shape elsewhere",
       bytes_of(svg("width='9mm' height='9mm'", "<g>\n</g>\n<use href='other.svg#a'/>")),
       Code::unusable_pattern,
       "the SVG refers to another file in its <use> element on line 3 (x); embed the picture in the "
       "drawing, or give the picture itself"},
      {"SVG whose reference was replaced by spaces",
       bytes_of(svg("width='9mm' height='9mm'", "\n<image href='          '/>")), Code::unusable_pattern,
       "the SVG refers to another file in its <image> element on line 2 (x); embed the picture in the "
       "drawing, or give the picture itself"},
      {"SVG that hides elements in an entity",
       bytes_of("<!DOCTYPE svg [<!ENTITY e '<image/>'>]>" + svg("width='9mm' height='9mm'", "&e;")),
       Code::unsupported_format,
       "the SVG's document type declares parts of the drawing (x); save it as plain SVG"},
      {"SVG around a PNG bomb", bytes_of(holding("image/png", png(0x7fffffff, 0x7fffffff, 8, 0, {{0}}))),
       Code::too_large,
       "the drawing has 2147483647 x 2147483647 pixels (x, embedded picture); give one of at most 64 million "
       "pixels, or an SVG"},
      {"SVG around another SVG", bytes_of(holding("image/svg+xml", bytes_of(svg("")))),
       Code::unsupported_format,
       "the SVG holds a picture that is neither PNG nor JPEG (x); embed it as PNG or JPEG"},
      {"SVG nested beyond reason", nested, Code::corrupt_file,
       "the SVG cannot be read: its elements are nested more than 200 deep (x); export the drawing again as "
       "plain SVG"},
  };
}

TEST(Pattern, RefusesWhatItCannotTrustAndSaysWhy) {
  for (const auto& r : refusals()) {
    const auto pattern = read(r.bytes, "x");
    ASSERT_FALSE(pattern) << r.what;
    EXPECT_EQ(meaning(pattern.error().code).slug, meaning(r.code).slug)
        << r.what << ": " << pattern.error().text();
    if (!r.message.empty()) {
      EXPECT_EQ(pattern.error().text(), r.message) << r.what;
    }
    EXPECT_FALSE(pattern.error().fix.empty()) << r.what;
  }
}

// Groups of ten copies of the previous group, `levels` deep.
std::string copies_of_copies(int levels) {
  std::string body = "<defs><g id='g0'><circle cx='9' cy='9' r='5'/></g>";
  for (int i = 1; i <= levels; ++i) {
    body += std::string("<g id='g") + std::to_string(i) + "'>";
    for (int k = 0; k < 10; ++k) body += std::string("<use href='#g") + std::to_string(i - 1) + "'/>";
    body += "</g>";
  }
  return body + "</defs><use href='#g" + std::to_string(levels) + "'/>";
}

TEST(Pattern, CountsTheWorkOfAnSvgBeforeItDraws) {
  const std::string attributes = "width='20mm' height='20mm' viewBox='0 0 20 20'";
  const auto refusal = [&](const std::string& body) {
    const std::clock_t started = std::clock();
    const auto pattern = read(bytes_of(svg(attributes, body)), "x");
    EXPECT_LT(static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC, 5);
    return pattern ? std::string() : pattern.error().text();
  };
  EXPECT_EQ(refusal(copies_of_copies(3)), "");
  std::string matrix = "1";
  for (int i = 1; i < 441; ++i) matrix += " 1";
  EXPECT_EQ(refusal("<filter id='f'><feConvolveMatrix order='21' kernelMatrix='" + matrix +
                    "'/></filter><rect width='9' height='9'/>"),
            "the SVG has a filter matrix of more than 800 bytes (x); remove the filter feConvolveMatrix, or "
            "give a picture");
  EXPECT_EQ(refusal(copies_of_copies(5)),
            "the SVG draws too many elements: 322223, above the limit of 100000 (x); make fewer copies with "
            "<use>, patterns, markers or dashes, or join shapes to paths");
  for (const int levels : {11, 18, 90})
    EXPECT_TRUE(refusal(copies_of_copies(levels)).starts_with("the SVG draws too many elements: "));
  EXPECT_TRUE(refusal(copies_of_copies(400)).starts_with("the SVG nests references to elements too deeply"));

  std::string path = "<path fill='none' stroke='black' stroke-width='1' d='";
  for (int i = 0; i < 5000; ++i) path += "M1 9c5 20 10 -20 15 0";
  EXPECT_TRUE(refusal(path + "'/>").starts_with("the SVG's outlines cross too often (estimated): "));
  EXPECT_EQ(refusal("<path stroke='black' d='M0 9H20' stroke-dasharray='1e-9'/>").substr(0, 31),
            "the SVG draws too many elements");
  std::string rules = "<style>";
  for (int i = 0; i < 3000; ++i) rules += "g .a{fill:red}";
  rules += "</style>";
  for (int i = 0; i < 3000; ++i) rules += "<rect class='a' width='1' height='1'/>";
  EXPECT_TRUE(refusal(rules).starts_with("the SVG has too many style rules for its elements: "));
  EXPECT_EQ(refusal("<rect width='5' height='5'/>").size(), 0u);
  // Values by entities count as what they stand for; those of other files stay what they are.
  const auto entities = [&](const std::string& declared) {
    return read("<!DOCTYPE svg [" + declared + "]>" + svg(attributes, "<rect width='&g;' height='5'/>"));
  };
  const auto inside = entities("<!ENTITY g '4'>");
  ASSERT_TRUE(inside) << inside.error().text();
  EXPECT_NEAR(inside->ink_mm2(), entities("<!ENTITY g '8'>")->ink_mm2() / 2, 1e-3 * inside->ink_mm2());
  const auto outside = entities("<!ENTITY g 'a'><!ENTITY f SYSTEM 'f'>");
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().what, "the SVG takes values from entities of its document type");
}

TEST(Pattern, DrawsCostlySvgsWithFewerPixels) {
  std::string body;
  for (int i = 0; i < 800; ++i) body += "<g opacity='.9'><rect width='20' height='20'/></g>";
  const auto plain = read(svg("width='100mm' height='100mm' viewBox='0 0 20 20'")),
             costly = read(svg("width='100mm' height='100mm' viewBox='0 0 20 20'", body));
  ASSERT_TRUE(plain && costly);
  EXPECT_EQ(plain->size_pixels().x(), 2000);
  EXPECT_LT(costly->size_pixels().x(), 1500);
  EXPECT_NEAR(costly->ink_mm2(), 10'000, 10);
}

TEST(Pattern, DrawsThePicturesInsideAnSvg) {
  for (const auto& text :
       {holding("image/png", gray_png(200, 100, 10000, [](int x, int) { return x < 100 ? 0 : 255; })),
        holding("image/jpeg", jpeg(200, 100, 1, [](int x, int, int) { return x < 100 ? 0 : 255; }))}) {
    const auto pattern = read(text);
    ASSERT_TRUE(pattern) << pattern.error().text();
    EXPECT_NEAR(pattern->ink_mm2(), 100, 1);
    EXPECT_NEAR(pattern->sample({-5, 0}, 1).coverage(), 1, 0.01);
  }
}

TEST(Pattern, EntitiesForNamesAreUnderstood) {
  const auto pattern = read(
      "<!DOCTYPE svg PUBLIC '-//W3C//DTD SVG 1.1//EN' 'http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd' "
      "[<!ENTITY ns 'http://www.w3.org/2000/svg'>]><svg xmlns='&ns;' width='9mm' height='9mm'>"
      "<rect width='90' height='90'/></svg>");
  ASSERT_TRUE(pattern) << pattern.error().text();
  EXPECT_NEAR(pattern->ink_mm2(), 81, 0.1);
}

TEST(Pattern, EntitiesThatGrowWithoutEndAreRefusedQuickly) {
  std::string bomb = "<!DOCTYPE svg [<!ENTITY a 'lollollollollollol'>";
  for (char c = 'b'; c <= 'l'; ++c) {
    bomb += std::string("<!ENTITY ") + c + " '";
    for (int i = 0; i < 10; ++i) bomb += std::string("&") + static_cast<char>(c - 1) + ";";
    bomb += "'>";
  }
  bomb += "]>" + svg("width='9mm' height='9mm'", "<text>&l;</text>");
  const auto start = std::chrono::steady_clock::now();
  const auto pattern = read(bomb);
  ASSERT_FALSE(pattern);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(Pattern, AnEntityCannotReadAFile) {
  const auto pattern = read("<!DOCTYPE svg [<!ENTITY f SYSTEM 'file:///etc/hostname'>]>" +
                            svg("width='90mm' height='90mm'", "<text y='20'>&f;</text>"));
  // Either the document is refused, or nothing of the file is drawn and the drawing is empty.
  ASSERT_FALSE(pattern);
  EXPECT_TRUE(pattern.error().code == Code::corrupt_file || pattern.error().code == Code::unusable_pattern);
}

TEST(Pattern, CompressedTextsInAPngAreNotUnpacked) {
  Bytes text = bytes_of("Comment");
  text.insert(text.end(), {0, 0});
  const Bytes zeros = deflated(Bytes(64 << 20, 0));
  text.insert(text.end(), zeros.begin(), zeros.end());
  Bytes extra = phys(1000, 1000);
  put_chunk(extra, "zTXt", text);
  const auto pattern = read(png(2, 2, 8, 0, {{0, 0}, {0, 0}}, extra));
  ASSERT_TRUE(pattern) << pattern.error().text();
  EXPECT_NEAR(pattern->ink_mm2(), 4, 1e-9);
}

TEST(Pattern, ReadsTheRings) {
  for (const auto& [name, width, rings] :
       {std::tuple{"rings-7x40mm.svg", 105.64, 7}, std::tuple{"rings-19x40mm.svg", 166.28, 19}}) {
    const auto pattern = read(ring_file(name), name, {}, 300);
    ASSERT_TRUE(pattern) << pattern.error().text();
    EXPECT_NEAR(pattern->size_mm().x(), width, 0.01);
    EXPECT_TRUE(pattern->grayscale());
    EXPECT_TRUE(pattern->warnings().empty());
    // Each pair of neighbours shares two crossings of its rings; the rest is the rings' own area.
    EXPECT_LT(pattern->ink_mm2(), rings * 2 * M_PI * 20 * 3);
    EXPECT_GT(pattern->ink_mm2(), 0.8 * rings * 2 * M_PI * 20 * 3);
  }
}

}  // namespace
}  // namespace vacuform
