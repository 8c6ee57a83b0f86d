// How large a drawing is: as its file says, as its program counts, or as somebody says who was asked.
#include <gtest/gtest.h>
#include <zlib.h>

#include "api/base/decimal.hpp"
#include "api/redaction/redaction.hpp"
#include "tests/unit/fixtures/drawing_files.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/drawing.hpp"
#include "worker/pattern/ink_checks.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

PatternSettings by(std::optional<double> width_mm, std::optional<double> dpi = {}) {
  PatternSettings settings;
  settings.width_mm = width_mm;
  settings.dpi = dpi;
  return settings;
}

// An ellipse that is off centre, in the file's own units.
constexpr const char* egg =
    "<ellipse id='egg' cx='41' cy='23' rx='12' ry='7' stroke='black' stroke-width='2' fill='none'/>";
std::string svg_file(const std::string& root, const std::string& body = egg, const std::string& before = "") {
  return before +
         "<svg xmlns='http://www.w3.org/2000/svg' "
         "xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' " +
         root + ">" + body + "</svg>";
}
const std::string illustrator =
    "<!-- Generator: Adobe Illustrator 24.0.1, SVG Export Plug-In . SVG Version: 6.00 Build 0)  -->\n";

// As it is read, and as the server stores it: both must say the same.
Result<Pattern> read_as_stored(const std::string& text, const PatternSettings& settings = {}) {
  auto pattern = Pattern::read(bytes_of(text), "drawing.svg", settings, 300);
  Bytes copy = bytes_of(text);
  const auto redacted = redact(copy, "drawing.svg");
  EXPECT_TRUE(redacted);
  const auto stored = Pattern::read(copy, "drawing.svg", settings, 300);
  EXPECT_EQ(pattern.has_value(), stored.has_value());
  if (pattern && stored) {
    EXPECT_LT((pattern->size_mm() - stored->size_mm()).norm(), 1e-12);
    EXPECT_EQ(pattern->size_from(), stored->size_from());
  }
  if (!pattern && !stored) {
    EXPECT_EQ(pattern.error().text(), stored.error().text());
  }
  return pattern;
}
// The box of the ink's centre lines.
Eigen::AlignedBox2d egg_of(const Pattern& pattern) {
  std::vector<Warning> warnings;
  const auto drawing = read_drawing(pattern, warnings);
  Eigen::AlignedBox2d box;
  if (!drawing) return box;
  for (const Element& e : drawing->elements)
    for (const Shape& s : e.shapes)
      for (const Curve& c : s.curves) box.extend(box_of(c));
  return box;
}

TEST(DrawingSize, TheProgramSaysHowLongAPixelIs) {
  struct Case {
    std::string text;
    double dpi;
    const char* from;
  };
  const std::string px = "width='144px' height='90px' viewBox='0 0 144 90'", bare = "width='144' height='90'";
  for (const auto& c :
       {Case{svg_file(px, egg, illustrator), 72, "144 x 90 px at 72 px/in, as Adobe Illustrator counts"},
        Case{svg_file("width='2in' height='90px' viewBox='0 0 144 90'", egg, illustrator), 72,
             "2 in x 90 px at 72 px/in, as Adobe Illustrator counts"},
        Case{svg_file("viewBox='0 0 144 90'", egg, illustrator), 72,
             "a viewBox of 144 x 90 units at 72 px/in, as Adobe Illustrator counts"},
        Case{svg_file(bare + " inkscape:version='0.91 r13725'"), 90,
             "144 x 90 at 90 px/in, as Inkscape 0.91 counts"},
        Case{svg_file(bare + " inkscape:version='0.48.4 r9939'"), 90,
             "144 x 90 at 90 px/in, as Inkscape 0.48.4 counts"},
        Case{svg_file(bare + " inkscape:version='0.92.3 (2405546, 2018-03-11)'"), 96,
             "144 x 90 at 96 px/in, as Inkscape 0.92.3 counts"},
        Case{svg_file(px + " inkscape:version='1.3.2 (091e20e, 2023-11-25)'"), 96,
             "144 x 90 px at 96 px/in, as Inkscape 1.3.2 counts"}}) {
    const auto pattern = read_as_stored(c.text);
    ASSERT_TRUE(pattern) << pattern.error().text();
    const double mm = 25.4 / c.dpi;
    EXPECT_LT((pattern->size_mm() - mm * Vector2d(144, 90)).norm(), 1e-9) << c.text;
    EXPECT_EQ(pattern->size_from(), c.from);
    const auto box = egg_of(*pattern);
    EXPECT_LT((box.min() - mm * Vector2d(41 - 12 - 72, 45 - 23 - 7)).norm(), 1e-9) << c.text;
    EXPECT_LT((box.max() - mm * Vector2d(41 + 12 - 72, 45 - 23 + 7)).norm(), 1e-9) << c.text;
    // Drawn as a picture it is the same.
    EXPECT_GT(pattern->sample(box.center() + Vector2d(0, 7 * mm), 0.05).coverage(), 0.95);
    EXPECT_TRUE(pattern->warnings().empty());
  }
}

TEST(DrawingSize, WhoeverKnowsNotIsAsked) {
  const std::string by_inkscape = " inkscape:version='1.2'";
  for (const auto& text :
       {svg_file("width='150' height='80' viewBox='0 0 150 80'"),
        svg_file("width='150px' height='80px' viewBox='0 0 150 80'"), svg_file("width='150px' height='80px'"),
        svg_file("width='100%' height='100%' viewBox='0 0 150 80'"),  // Affinity Designer
        svg_file("viewBox='0 0 150 80'" + by_inkscape),
        svg_file("width='60mm' height='80px' viewBox='0 0 150 80'"),
        svg_file("width='150' height='80'" + by_inkscape, egg, illustrator),  // which of the two?
        svg_file("width='150' height='80'", egg, "<!-- Generator: Adobe Illustratory 2 -->")}) {
    const auto pattern = read_as_stored(text);
    ASSERT_FALSE(pattern) << text << pattern->size_from();
    EXPECT_EQ(pattern.error().code, Code::unusable_pattern);
    // Each proposal gives what it says.
    ASSERT_GE(pattern.error().proposals.size(), 3u);
    for (const Proposal& p : pattern.error().proposals) {
      ASSERT_EQ(p.set.size(), 1u);
      const bool width = p.set[0].name == "pattern.width_mm";
      const auto settled = read_as_stored(text, width ? by(p.set[0].number) : by({}, p.set[0].number));
      ASSERT_TRUE(settled) << p.text << settled.error().text();
      const std::string said =
          decimal(settled->size_mm().x(), 1) + " x " + decimal(settled->size_mm().y(), 1) + " mm,";
      EXPECT_TRUE(p.text.starts_with(said)) << p.text << "; " << said;
      EXPECT_TRUE(settled->size_from().ends_with(" says")) << settled->size_from();
    }
  }
  const auto bare = read_as_stored(svg_file("width='120' height='80' viewBox='0 0 120 80'"));
  EXPECT_EQ(
      bare.error().text(),
      "the SVG is 120 x 80, without a unit (drawing.svg); say how large it is: --set pattern.width_mm=120 "
      "(120.0 x 80.0 mm, if its numbers are mm), --set pattern.dpi=72 (42.3 x 28.2 mm, as Illustrator, "
      "Affinity "
      "and PDF count), --set pattern.dpi=90 (33.9 x 22.6 mm, as Inkscape before 0.92 counts) or --set "
      "pattern.dpi=96 (31.8 x 21.2 mm, as browsers and Inkscape count); or export it with its width and "
      "height in "
      "mm");
}

// Roots of files that people reported to other programs, which took them for another size. A width of 0: it is asked.
TEST(DrawingSize, RootsThatOtherProgramsTookForAnotherSize) {
  struct Case {
    const char* report;
    std::string root;
    Vector2d mm, egg_mm;
  };
  const double pt = 25.4 / 72, old_px = 25.4 / 90;
  for (const auto& c : {
           Case{"OpenBuilds-CAM 98, by Cairo", "width='612pt' height='792pt' viewBox='0 0 612 792'",
                pt * Vector2d(612, 792), pt * Vector2d(24, 14)},
           Case{"OpenBuilds-CAM 76",
                "width='50mm' height='50mm' viewBox='0 0 177.16535 177.16535' "
                "inkscape:version='0.91 r13725'",
                {50, 50},
                50 / 177.16535 * Vector2d(24, 14)},
           Case{"LasaurApp 72, no viewBox",
                "width='1220mm' height='610mm' inkscape:version='0.48.4 r9939'",
                {1220, 610},
                old_px * Vector2d(24, 14)},
           Case{"LaserWeb4 223, by CorelDRAW",
                "width='457.285mm' height='135.043mm' viewBox='0 0 38014 11224'",
                {457.285, 135.043},
                457.285 / 38014 * Vector2d(24, 14)},
           Case{"cnc-text-tool 5",
                "width='60in' height='50in' viewBox='0 0 60 50'",
                {1524, 1270},
                25.4 * Vector2d(24, 14)},
           Case{"not square: the shorter side counts",
                "width='100mm' height='100mm' viewBox='0 0 200 80'",
                {100, 100},
                0.5 * Vector2d(24, 14)},
           Case{"LaserWeb4 346, by Illustrator without its comment",
                "width='850.39px' height='566.93px' viewBox='0 0 850.39 566.93'",
                {0, 0},
                {0, 0}},
           Case{"grid-apps 299, by Affinity",
                "width='100%' height='100%' viewBox='0 0 3508 4961'",
                {0, 0},
                {0, 0}},
           Case{"openscad 1122", "width='100' height='100' viewBox='-1 -101 102 102'", {0, 0}, {0, 0}},
           Case{"meerk40t 1228", "viewBox='0 0 72.5 72.5'", {0, 0}, {0, 0}},
           Case{"Proxy-PDF-Maker 62, by Qt", "baseProfile='tiny' version='1.2'", {0, 0}, {0, 0}},
           Case{"libvips 4628", "width='100' height='100' viewBox='0 0 100 100'", {0, 0}, {0, 0}},
       }) {
    const auto pattern = read_as_stored(svg_file(c.root));
    ASSERT_EQ(pattern.has_value(), c.mm.x() > 0) << c.report;
    if (!pattern) continue;
    EXPECT_LT((pattern->size_mm() - c.mm).norm(), 1e-6) << c.report;
    EXPECT_LT((egg_of(*pattern).sizes() - c.egg_mm).norm(), 1e-6) << c.report;
  }
}

TEST(DrawingSize, UnitsMayBeInCapitals) {
  const auto pattern = read_as_stored(svg_file("width='120MM' height='8Cm' viewBox='0 0 120 80'"));
  ASSERT_TRUE(pattern) << pattern.error().text();
  EXPECT_LT((pattern->size_mm() - Vector2d(120, 80)).norm(), 1e-9);
  EXPECT_NEAR(egg_of(*pattern).sizes().x(), 24, 1e-9);
}

// In Inkscape 0.91, 10 mm inside the drawing are 35.43 of its pixels, not 37.8.
TEST(DrawingSize, LengthsInsideCountAsTheProgramCounts) {
  const std::string body =
      "<style>.w{stroke-width:2mm;stroke:#00f5cc}</style><circle class='w' fill='none' cx='3cm' cy='100' "
      "r='10mm' "
      "style='stroke-dasharray:1.5in,1pt'/>";
  const auto pattern =
      read_as_stored(svg_file("width='425.19685' height='283.46457' inkscape:version='0.91 r13725'", body));
  ASSERT_TRUE(pattern) << pattern.error().text();
  std::vector<Warning> warnings;
  const auto drawing = read_drawing(*pattern, warnings);
  ASSERT_TRUE(drawing);
  const Shape& shape = drawing->elements.at(0).shapes.at(0);
  EXPECT_NEAR(egg_of(*pattern).sizes().x(), 20, 1e-6);
  EXPECT_NEAR(egg_of(*pattern).center().x(), 30 - 60, 1e-4);
  ASSERT_TRUE(shape.stroke);
  EXPECT_NEAR(shape.stroke->width_mm, 2, 1e-6);
  EXPECT_NEAR(shape.stroke->colour.g, 0xf5 / 255.0, 1e-9);
  ASSERT_EQ(shape.stroke->dashes_mm.size(), 2u);
  EXPECT_NEAR(shape.stroke->dashes_mm[0], 38.1, 1e-6);
  EXPECT_NEAR(shape.stroke->dashes_mm[1], 25.4 / 72, 1e-6);
}

TEST(DrawingSize, WithoutAViewBoxTheShapesAreWarnedOf) {
  const std::string text = svg_file("width='40mm' height='30mm'");
  const auto pattern = read_as_stored(text);
  ASSERT_TRUE(pattern);
  ASSERT_EQ(pattern->warnings().size(), 1u);
  EXPECT_EQ(pattern->warnings()[0].code, "pattern-units");
  EXPECT_NEAR(egg_of(*pattern).sizes().x(), 24 * 25.4 / 96, 1e-9);
  const auto settled = read_as_stored(text, by({}, 72));
  ASSERT_TRUE(settled);
  EXPECT_TRUE(settled->warnings().empty());
  EXPECT_EQ(settled->size_mm(), Vector2d(40, 30));
  EXPECT_NEAR(egg_of(*settled).sizes().x(), 24 * 25.4 / 72, 1e-9);
  EXPECT_NEAR(egg_of(*settled).center().x(), 41 * 25.4 / 72 - 20, 1e-9);
}

TEST(DrawingSize, ASettingThatHasNoEffectIsSaid) {
  const auto pattern = read_as_stored(svg_file("width='40mm' height='30mm' viewBox='0 0 80 60'"), by({}, 72));
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->size_from(), "40 x 30 mm, as the file says; pattern.dpi has no effect");
}

// The Exif data of a camera or an editor, behind the JFIF header of `jpeg`.
Bytes with_exif(const Bytes& jpeg, const Bytes& tiff) {
  Bytes out(jpeg.begin(), jpeg.begin() + 20), exif = bytes_of(std::string("Exif\0\0", 6));
  exif.insert(exif.end(), tiff.begin(), tiff.end());
  out.insert(out.end(), {0xff, 0xe1, 0, static_cast<std::uint8_t>(exif.size() + 2)});
  out.insert(out.end(), exif.begin(), exif.end());
  out.insert(out.end(), jpeg.begin() + 20, jpeg.end());
  return out;
}
// Little endian, with rationals: `dpi` / 10 pixels an inch or a centimetre.
Bytes tiff_of(std::uint8_t x, std::uint8_t y, std::uint8_t unit) {
  return {'I',  'I', 42, 0, 8, 0,    0, 0, 3,  0,  //
          0x1a, 1,   5,  0, 1, 0,    0, 0, 50, 0, 0, 0, 0x1b, 1,    5, 0, 1, 0, 0,
          0,    58,  0,  0, 0, 0x28, 1, 3, 0,  1, 0, 0, 0,    unit, 0, 0, 0, 0, 0,
          0,    0,   x,  0, 0, 0,    1, 0, 0,  0, y, 0, 0,    0,    1, 0, 0, 0};
}

TEST(DrawingSize, TwoResolutionsOfAJpegThatContradictEachOtherAreAskedAbout) {
  const auto read_both = [](Bytes bytes, const PatternSettings& settings = {}) {
    auto pattern = Pattern::read(bytes, "p.jpg", settings, 150);
    EXPECT_TRUE(redact(bytes, "p.jpg"));
    const auto stored = Pattern::read(bytes, "p.jpg", settings, 150);
    EXPECT_EQ(pattern ? pattern->size_from() : pattern.error().text(),
              stored ? stored->size_from() : stored.error().text());
    return pattern;
  };
  const auto jfif = [](std::uint8_t unit, std::uint8_t density) {
    Bytes bytes = jpeg(240, 120, 1, [](int x, int, int) { return x < 30 ? 0 : 255; });
    bytes[13] = unit, bytes[14] = bytes[16] = 0, bytes[15] = bytes[17] = density;
    return bytes;
  };
  const Bytes at_72 = jfif(1, 72), without = jfif(0, 1);
  const auto asked = read_both(with_exif(at_72, tiff_of(100, 100, 2)));
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().text(),
            "the JPEG has 72 pixels an inch by its JFIF data and 100 by its Exif data (p.jpg); say how large "
            "it is: "
            "--set pattern.dpi=72 (84.7 x 42.3 mm, as its JFIF data says) or --set pattern.dpi=100 (61.0 x "
            "30.5 mm, as "
            "its Exif data says); or give pattern.width_mm");
  EXPECT_EQ(asked.error().code, Code::unusable_pattern);
  EXPECT_NEAR(read_both(with_exif(at_72, tiff_of(100, 100, 2)), by({}, 100))->size_mm().x(), 60.96, 1e-9);
  // JFIF rounds.
  const auto same = read_both(with_exif(jfif(2, 59), tiff_of(150, 150, 2)));
  ASSERT_TRUE(same) << same.error().text();
  EXPECT_NEAR(same->size_mm().x(), 2400 / 59.0, 1e-9);
  // One of them is enough.
  const auto exif = read_both(with_exif(without, tiff_of(40, 20, 3)));
  ASSERT_TRUE(exif) << exif.error().text();
  EXPECT_LT((exif->size_mm() - Vector2d(60, 60)).norm(), 1e-9);
}

TEST(DrawingSize, ThePixelsOfAPictureAreAsLongAsTheSettingSays) {
  const auto pattern = Pattern::read(gray_png(300, 150, 1000, [](int x, int) { return x < 60 ? 0 : 255; }),
                                     "p.png", by({}, 150), 150);
  ASSERT_TRUE(pattern);
  EXPECT_LT((pattern->size_mm() - Vector2d(50.8, 25.4)).norm(), 1e-9);
  EXPECT_EQ(pattern->size_from(), "150 pixels an inch, as pattern.dpi says");
}

// KiCad writes each text twice: as strokes, and as letters that nobody sees.
TEST(DrawingSize, LettersThatNobodySeesLeaveTheLines) {
  for (const char* hidden :
       {"<text opacity='0' x='3' y='4'>R1</text>", "<text style='visibility:hidden'>R1</text>",
        "<text fill='none'>R1</text>", "<text fill-opacity='0' stroke='none'>R1</text>",
        "<g opacity='0'><text>R1</text></g>", "<text><tspan opacity='0'>R1</tspan></text>",
        "<text visibility='hidden'><title>R1</title></text>"}) {
    const auto pattern =
        read_as_stored(svg_file("width='80mm' height='60mm' viewBox='0 0 80 60'", hidden + std::string(egg)));
    ASSERT_TRUE(pattern);
    EXPECT_NEAR(egg_of(*pattern).sizes().x(), 24, 1e-9) << hidden;
  }
  for (const char* shown : {"<text y='9'>R1</text>",
                            "<text visibility='hidden' y='9'><tspan visibility='visible'>R1</tspan></text>",
                            "<text fill='none' stroke='red' y='9'>R1</text>"}) {
    const auto pattern =
        read_as_stored(svg_file("width='80mm' height='60mm' viewBox='0 0 80 60'", shown + std::string(egg)));
    ASSERT_TRUE(pattern);
    EXPECT_TRUE(egg_of(*pattern).isEmpty()) << shown;
  }
}

std::string utf16(const std::string& text, bool big, bool mark) {
  std::string out = !mark ? "" : big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) out += big ? std::string{'\0', c} : std::string{c, '\0'};
  return out;
}

TEST(DrawingSize, EncodingsAndEntitiesLeaveTheLines) {
  const std::string text = svg_file("width='80mm' height='60mm' viewBox='0 0 80 60'");
  const std::string native =
      "<!DOCTYPE svg PUBLIC '-//W3C//DTD SVG 1.1//EN' 'http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd' [\n"
      "<!ENTITY ns_ai 'http://ns.adobe.com/AdobeIllustrator/10.0/'>\n<!ENTITY ns_svg "
      "'http://www.w3.org/2000/svg'>]>"
      "<svg xmlns='&ns_svg;' xmlns:i='&ns_ai;' width='80mm' height='60mm' viewBox='0 0 80 60'><switch>"
      "<foreignObject requiredExtensions='&ns_ai;' width='1' height='1'><i:aipgfRef/></foreignObject>"
      "<g i:extraneous='self'>" +
      std::string(egg) + "</g></switch></svg>";
  for (const std::string& each : {utf16(text, false, true), utf16(text, true, true),
                                  utf16(text, false, false), utf16(text, true, false), native}) {
    const auto pattern = read_as_stored(each);
    ASSERT_TRUE(pattern) << pattern.error().text();
    EXPECT_NEAR(egg_of(*pattern).sizes().x(), 24, 1e-9);
  }
}

std::string gzipped(const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string out(deflateBound(&stream, text.size()) + 100, '\0'), in = text;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

TEST(DrawingSize, APackedSvgIsUnpacked) {
  const std::string text =
      svg_file("width='80mm' height='60mm' viewBox='0 0 80 60'", egg + std::string("<!--Jane Doe-->"));
  const std::string packed = gzipped(text);
  for (const std::string& each : {packed, packed + std::string(7, '\0')}) {
    const auto pattern = read_as_stored(each);
    ASSERT_TRUE(pattern) << pattern.error().text();
    EXPECT_EQ(pattern->format(), "SVG");
    EXPECT_NEAR(egg_of(*pattern).sizes().x(), 24, 1e-9);
  }
  // The copy of the server is plain, and without the comment.
  Bytes copy = bytes_of(packed);
  ASSERT_TRUE(redact(copy, "drawing.svgz"));
  EXPECT_EQ(std::string(copy.begin(), copy.end()).find("Jane"), std::string::npos);
  EXPECT_EQ(copy.at(0), '<');

  const auto refused = [](const std::string& bytes) {
    const auto pattern = Pattern::read(bytes_of(bytes), "x", {}, 300);
    return pattern ? "read" : pattern.error().text();
  };
  EXPECT_EQ(refused(packed.substr(0, packed.size() / 2)),
            "the packed file is damaged: it ends early (x); unpack the file, or export it again");
  EXPECT_EQ(refused(packed + "rest").substr(0, 26), "the packed file is damaged");
  EXPECT_EQ(refused(gzipped("solid head")),
            "the drawing is compressed (x); unpack it: give a PNG, JPEG or SVG file");
  EXPECT_EQ(refused(gzipped(std::string(64 << 20, ' '))).substr(0, 40),
            "the packed file has more than 32 MiB whe");
}

std::vector<Warning> ink_warnings(const std::string& body, double scale = 1, int dpi = 300) {
  const auto pattern = read_as_stored(svg_file("width='90mm' height='70mm' viewBox='0 0 90 70'", body));
  if (!pattern) throw std::runtime_error(pattern.error().text());
  std::vector<Warning> warnings;
  return check_ink(*pattern, read_drawing(*pattern, warnings), scale, dpi);
}

TEST(InkChecks, LinesThatThePrintCannotHoldAreNamed) {
  const std::string two =
      "<g id='left' transform='rotate(17)'><circle cx='31' cy='22' r='11' fill='none' stroke='#000' "
      "stroke-width='0.01'/></g>"
      "<path id='right' d='M50 9C60 3 70 33 81 24' fill='none' stroke='#000' stroke-width='0.07'/>"
      "<rect id='pad' x='9' y='55' width='4' height='2' stroke='#000' stroke-width='0.01'/>";
  const auto fine = ink_warnings(two);
  ASSERT_EQ(fine.size(), 1u);
  EXPECT_EQ(fine[0].code, "lines-thin");
  EXPECT_EQ(fine[0].place, "left");
  EXPECT_EQ(fine[0].text,
            "1 line is narrower than 0.05 mm, the least that the print can hold; the narrowest has 0.01 mm.");
  EXPECT_EQ(ink_warnings(two, 0.5).at(0).place, "left, right");
  EXPECT_EQ(ink_warnings(two, 1, 72).at(0).place, "left, right");  // half a pixel has 0.18 mm
  EXPECT_TRUE(ink_warnings(two, 6).empty());
}

TEST(InkChecks, ADarkBackgroundIsWarnedOf) {
  const std::string coils =
      "<g id='a'><circle cx='31' cy='32' r='11' fill='none' stroke='#c83434' stroke-width='2'/></g>"
      "<g id='b'><circle cx='49' cy='27' r='11' fill='none' stroke='#c83434' stroke-width='2'/></g>";
  EXPECT_TRUE(ink_warnings(coils).empty());
  EXPECT_TRUE(ink_warnings("<rect width='100%' height='100%' fill='#fff'/>" + coils).empty());
  const auto dark = ink_warnings("<rect width='100%' height='100%' fill='#001023'/>" + coils);
  ASSERT_EQ(dark.size(), 1u);
  EXPECT_EQ(dark[0].code, "pattern-dark");
  EXPECT_GT(dark[0].figure->value, 85);
  // A plate under the coils alone covers less than half of the page.
  const auto plate = ink_warnings("<ellipse cx='40' cy='30' rx='27' ry='21' fill='#777'/>" + coils);
  ASSERT_EQ(plate.size(), 1u);
  EXPECT_NE(plate[0].text.find("lies under all 2 coils"), std::string::npos) << plate[0].text;
}

TEST(DrawingSize, OtherFormatsAreRefusedByName) {
  using namespace std::string_literals;
  const auto refused = [](const std::string& bytes) {
    const auto pattern = Pattern::read(bytes_of(bytes), "x", {}, 300);
    return pattern ? "read" : pattern.error().text();
  };
  const std::pair<std::string, std::string> cases[] = {
      {"%PDF-1.5\n%",
       "the drawing is a PDF or Adobe Illustrator file (x); export the drawing as SVG from the program that "
       "made it"},
      {"%!PS-Adobe-3.0 EPSF-3.0\n",
       "the drawing is a PostScript, EPS or Adobe Illustrator file (x); export the drawing as SVG from the "
       "program that made it"},
      {"\xc5\xd0\xd3\xc6\x20\0\0\0"s,
       "the drawing is an EPS file (x); export the drawing as SVG from the program that made it"},
      {"II*\0\x08\0\0\0"s, "the drawing is a TIFF picture (x); save it as PNG or JPEG"},
      {"MM\0*\0\0\0\x08"s, "the drawing is a TIFF picture (x); save it as PNG or JPEG"},
      {"RIFF\x24\0\0\0WEBPVP8 "s, "the drawing is a WebP picture (x); save it as PNG or JPEG"},
      {"GIF89a\x01\0"s, "the drawing is a GIF picture (x); save it as PNG or JPEG"}};
  for (const auto& [bytes, message] : cases) EXPECT_EQ(refused(bytes), message);
}

}  // namespace
}  // namespace vacuform
