#include "worker/printing/print.hpp"

#include <glib.h>
#include <gtest/gtest.h>

#include <cmath>
#include <pugixml.hpp>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "tests/unit/fixtures/ring_files.hpp"
#include "worker/placement/alignment.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using hand_made::Sample;

Pattern pattern_of(const Bytes& bytes, const Settings& settings) {
  auto pattern = Pattern::read(bytes, "drawing", settings.pattern, settings.print.dpi);
  if (!pattern) throw std::runtime_error(pattern.error().text());
  return std::move(*pattern);
}
Pattern svg_pattern(const std::string& body, double side, const Settings& settings) {
  const std::string mm = std::to_string(side), half = std::to_string(-side / 2);
  return pattern_of(
      bytes_of("<svg xmlns='http://www.w3.org/2000/svg' width='" + mm + "mm' height='" + mm +
               "mm' viewBox='" + half + " " + half + " " + mm + " " + mm + "'>" + body + "</svg>"),
      settings);
}
// Settings for a pattern that is a picture.
Result<Print> try_print(const Sample& x, const Pattern& pattern, const PrintLabel& label = {"3f9a12c4"},
                        const Context& context = Context()) {
  const auto placement = place(hand_made::Charted(x), nullptr, x.settings, Context());
  if (!placement) throw std::runtime_error(placement.error().text());
  return make_print({.charted = hand_made::Charted(x),
                     .placement = *placement,
                     .settings = x.settings,
                     .label = label,
                     .layers = {{.name = "print",
                                 .face = x.settings.pattern.inked_face,
                                 .source = picture_layer(pattern, *placement, nullptr, false)}}},
                    context);
}
// The source of its layer refers to a placement that is gone: only what was made from it may be read.
Print print_of(const Sample& x, const Pattern& pattern) {
  auto print = try_print(x, pattern);
  if (!print) throw std::runtime_error(print.error().text());
  return std::move(*print);
}

// Ink of a picture: its area and centre in sheet coordinates, and its extent.
struct Extent {
  double area = 0, s = 0, t = 0, left = 1e9, right = -1e9, low = 1e9, high = -1e9;
};
Extent extent(const Layer& layer, double pixel_mm) {
  const Decoded image = decode_png(layer.files.png);
  Extent e;
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      const double ink = (255 - image.at(i, j)) / 255.0 * image.at(i, j, 3) / 255.0;
      const double s = (i + 0.5 - 0.5 * image.width) * pixel_mm,
                   t = (0.5 * image.height - j - 0.5) * pixel_mm;
      e.area += ink, e.s += ink * s, e.t += ink * t;
      if (ink < 0.5) continue;
      e.left = std::min(e.left, s), e.right = std::max(e.right, s), e.low = std::min(e.low, t),
      e.high = std::max(e.high, t);
    }
  e.s /= e.area, e.t /= e.area, e.area *= pixel_mm * pixel_mm;
  return e;
}
Extent extent(const Print& print) { return extent(print.main(), print.grid.pixel_mm); }

TEST(Print, AFlatSheetGivesTheDrawingBack) {
  // 100 mm of drawing in pixels of 0.1 mm on 120 mm of sheet at the same resolution: the pixels coincide.
  Sample x = hand_made::flat(120, 24);
  x.settings.print.dpi = 254;
  x.settings.print.marks = false;
  const auto gray = [](int i, int j) {
    return static_cast<int>(std::lround(127.5 + 100 * std::sin(i / 25.0) * std::cos(j / 31.0)));
  };
  const Print print = print_of(x, pattern_of(gray_png(1000, 1000, 10000, gray), x.settings));
  const Decoded image = decode_png(print.main().files.png);
  ASSERT_EQ(image.width, 1200);
  ASSERT_EQ(image.height, 1200);
  int worst = 0;
  for (int j = 1; j < 999; ++j)
    for (int i = 1; i < 999; ++i) worst = std::max(worst, std::abs(image.at(i + 100, j + 100) - gray(i, j)));
  EXPECT_LE(worst, 1);
  EXPECT_EQ(image.at(50, 600), 255);  // off the drawing
  EXPECT_NEAR(print.main().ink_printed, 1, 1e-6);
  EXPECT_TRUE(print.warnings.empty());
}

TEST(Print, PutsTheExactResolutionIntoTheFile) {
  for (const auto& [dpi, per_metre, pixels] :
       {std::tuple{72, 2835, 341}, std::tuple{300, 11811, 1418}, std::tuple{600, 23622, 2835}}) {
    Sample x = hand_made::flat(120, 4);
    x.settings.print.dpi = dpi;
    const Print print = print_of(x, svg_pattern("<circle r='20'/>", 60, x.settings));
    Bytes expected;
    put32(expected, static_cast<std::uint32_t>(per_metre));
    put32(expected, static_cast<std::uint32_t>(per_metre));
    expected.push_back(1);
    const auto at = static_cast<std::ptrdiff_t>(chunk(print.main().files.png, "pHYs"));
    ASSERT_GT(at, 0);
    EXPECT_EQ(Bytes(print.main().files.png.begin() + at, print.main().files.png.begin() + at + 9), expected)
        << dpi;
    EXPECT_EQ(print.grid.width, pixels);
    EXPECT_EQ(print.grid.height, pixels);
    const Decoded image = decode_png(print.main().files.png);
    EXPECT_EQ(image.width, pixels);
    EXPECT_EQ(print.main().files.png[chunk(print.main().files.png, "IHDR") + 9], 0) << "gray";
  }
}

TEST(Print, AStretchIsUndone) {
  // The sheet doubles along s when it is formed, so a round drawing is printed half as wide.
  Eigen::Matrix2d stretch;
  stretch << 2, 0, 0, 1.25;
  Sample x = hand_made::stretched(120, 30, stretch);
  x.settings.print.marks = false;
  const Extent e = extent(print_of(x, svg_pattern("<circle r='20'/>", 60, x.settings)));
  EXPECT_NEAR(e.right - e.left, 20, 0.15);
  EXPECT_NEAR(e.high - e.low, 32, 0.15);
  EXPECT_NEAR(e.area, M_PI * 400 / 2.5, 0.5);
  EXPECT_NEAR(e.s, 0, 0.01);
  EXPECT_NEAR(e.t, 0, 0.01);
}

TEST(Print, OffsetRotationAndScaleActOnTheFormedPart) {
  Sample x = hand_made::flat(200, 20);
  x.settings.print.marks = false;
  x.settings.print.dpi = 150;
  // A dot 10 mm to the right of the drawing's middle (SVG's y goes down: 4 mm above it).
  const std::string dot = "<circle cx='10' cy='-4' r='2'/>";
  Extent e = extent(print_of(x, svg_pattern(dot, 40, x.settings)));
  EXPECT_NEAR(e.s, 10, 0.02);
  EXPECT_NEAR(e.t, 4, 0.02);

  x.settings.pattern.offset_mm = {30, -20};
  e = extent(print_of(x, svg_pattern(dot, 40, x.settings)));
  EXPECT_NEAR(e.s, 40, 0.02);
  EXPECT_NEAR(e.t, -16, 0.02);

  x.settings.pattern.rotate_deg = 90;  // counter-clockwise: (10, 4) goes to (-4, 10)
  e = extent(print_of(x, svg_pattern(dot, 40, x.settings)));
  EXPECT_NEAR(e.s, 26, 0.02);
  EXPECT_NEAR(e.t, -10, 0.02);

  x.settings.pattern.scale = 2;
  e = extent(print_of(x, svg_pattern(dot, 40, x.settings)));
  EXPECT_NEAR(e.s, 22, 0.02);
  EXPECT_NEAR(e.t, 0, 0.02);
  EXPECT_NEAR(e.area, M_PI * 16, 0.1);
  const Eigen::Vector2d uv = plain_alignment(x.settings.pattern).pattern({22, 0});
  EXPECT_NEAR(uv.x(), 10, 1e-12);
  EXPECT_NEAR(uv.y(), 4, 1e-12);
}

TEST(Print, TheInnerFaceIsTheOuterMirrored) {
  Sample x = hand_made::flat(100, 10);
  x.settings.print.marks = false;
  x.settings.print.dpi = 200;
  for (const char* colour : {"#000", "#06c"}) {
    const std::string body = std::string("<path d='M0,0 L30,0 L30,10 Z' fill='") + colour + "'/>";
    x.settings.pattern.inked_face = InkedFace::outer;
    const Print outer = print_of(x, svg_pattern(body, 70, x.settings));
    x.settings.pattern.inked_face = InkedFace::inner;
    const Print inner = print_of(x, svg_pattern(body, 70, x.settings));
    EXPECT_FALSE(outer.main().mirrored());
    EXPECT_TRUE(inner.main().mirrored());
    const Decoded a = decode_png(outer.main().files.png), b = decode_png(inner.main().files.png);
    ASSERT_EQ(a.width, b.width);
    bool differs = false;
    for (int j = 0; j < a.height; ++j)
      for (int i = 0; i < a.width; ++i)
        for (int c = 0; c < 4; ++c) {
          ASSERT_EQ(a.at(i, j, c), b.at(a.width - 1 - i, j, c));
          differs |= a.at(i, j, c) != b.at(i, j, c);
        }
    EXPECT_TRUE(differs);
    EXPECT_GT(outer.picture_uv({20, 0}).x(), 0.5);
    EXPECT_LT(inner.picture_uv({20, 0}).x(), 0.5);
    EXPECT_EQ(inner.picture_uv({20, 30}).y(), outer.picture_uv({20, 30}).y());
  }
}

// A dot to the right in the middle of the outer face, and one above it in part off the chart, on the inner face.
TEST(Print, EachLayerHasItsOwnInkFaceAndFiles) {
  Sample x = hand_made::flat(200, 40, 60);
  x.settings.print.dpi = 100;
  const auto placement = place(hand_made::Charted(x), nullptr, x.settings, Context());
  ASSERT_TRUE(placement);
  const Pattern right = svg_pattern("<circle cx='15' r='8'/>", 140, x.settings),
                above = svg_pattern("<circle cx='10' cy='-55' r='8' fill='#c00'/>", 140, x.settings);
  const auto printed = [&](bool marks) {
    x.settings.print.marks = marks;
    auto print = make_print({.charted = hand_made::Charted(x),
                             .placement = *placement,
                             .settings = x.settings,
                             .label = {"3f9a12c4"},
                             .layers = {{.name = "print",
                                         .face = InkedFace::outer,
                                         .source = picture_layer(right, *placement, nullptr, false)},
                                        {.name = "colours",
                                         .face = InkedFace::inner,
                                         .source = picture_layer(above, *placement, nullptr, false)}}},
                            Context());
    if (!print) throw std::runtime_error(print.error().text());
    return std::move(*print);
  };
  const Print bare = printed(false);
  ASSERT_EQ(bare.layers.size(), 2u);
  const Extent first = extent(bare.layers[0], bare.grid.pixel_mm),
               second = extent(bare.layers[1], bare.grid.pixel_mm);
  EXPECT_NEAR(first.s, 15, 0.1);
  EXPECT_NEAR(first.t, 0, 0.1);
  EXPECT_NEAR(second.s, -10, 1);  // mirrored
  EXPECT_GT(second.t, 50);
  EXPECT_EQ(bare.layers[0].ink_printed, 1);
  EXPECT_GT(bare.layers[1].ink_printed, 0.2);
  EXPECT_LT(bare.layers[1].ink_printed, 0.8);
  ASSERT_EQ(bare.warnings.size(), 1u);
  EXPECT_EQ(bare.warnings[0].code, "ink-off-chart");

  const Print marked = printed(true);
  const std::string &outer = marked.layers[0].files.svg, &inner = marked.layers[1].files.svg;
  EXPECT_NE(outer.find("outer face, seen from above"), std::string::npos);
  EXPECT_EQ(outer.find("scale(-1 1)"), std::string::npos);
  EXPECT_NE(inner.find("inner face, MIRRORED"), std::string::npos);
  EXPECT_NE(inner.find("scale(-1 1)"), std::string::npos);
}

TEST(Print, HasNoSeamsAndASmoothBorder) {
  // All black: inside the chart every pixel is black, and the ink's area is the chart's area.
  Sample x = hand_made::flat(120, 37, 40);
  x.settings.print.marks = false;
  double chart = 0;
  for (const int t : x.flattening.triangles) {
    const auto& c = x.sheet.triangles[static_cast<std::size_t>(t)];
    const auto p = [&](int k) {
      return x.sheet.rest[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])];
    };
    const Eigen::Vector2d a = p(1) - p(0), b = p(2) - p(0);
    chart += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  const Print print =
      print_of(x, svg_pattern("<rect x='-80' y='-80' width='160' height='160'/>", 140, x.settings));
  EXPECT_NEAR(extent(print).area, chart, 0.002 * chart);
  const Decoded image = decode_png(print.main().files.png);
  int grays = 0;
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      const double s = (i + 0.5 - 0.5 * image.width) * print.grid.pixel_mm,
                   t = (0.5 * image.height - j - 0.5) * print.grid.pixel_mm;
      const double r = std::hypot(s, t);
      ASSERT_TRUE(r > 35 || image.at(i, j) == 0) << i << ", " << j;
      ASSERT_TRUE(r < 40.2 || image.at(i, j) == 255) << i << ", " << j;
      grays += image.at(i, j) > 0 && image.at(i, j) < 255;
    }
  EXPECT_GT(grays, 100);
}

constexpr const char* orange =
    "<rect x='-10' y='-10' width='20' height='20' fill='#c8640a' fill-opacity='0.5'/>";

TEST(Print, ColourLiesOnWhite) {
  const Sample x = hand_made::flat(100, 10);
  const Print print = print_of(x, svg_pattern(orange, 40, x.settings));
  const Decoded image = decode_png(print.main().files.png);
  EXPECT_EQ(print.main().files.png[chunk(print.main().files.png, "IHDR") + 9], 2) << "RGB";
  const int middle = image.width / 2;
  EXPECT_NEAR(image.at(middle, middle, 0), 228, 1);
  EXPECT_NEAR(image.at(middle, middle, 1), 178, 1);
  EXPECT_NEAR(image.at(middle, middle, 2), 133, 1);
  int white = 0, black = 0;
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      white += image.at(i, j, 0) == 255 && image.at(i, j, 1) == 255 && image.at(i, j, 2) == 255;
      black += image.at(i, j, 0) == 0;
    }
  EXPECT_GT(white, 0.9 * image.width * image.height);
  EXPECT_LT(black, 0.04 * image.width * image.height);  // only the marks
}

TEST(Print, ColourIsKeptAndTheRestIsTransparentWhereThatIsAskedFor) {
  Sample x = hand_made::flat(100, 10);
  x.settings.print.marks = false;
  x.settings.print.background = Background::transparent;
  const Print print = print_of(x, svg_pattern(orange, 40, x.settings));
  const Decoded image = decode_png(print.main().files.png);
  EXPECT_EQ(print.main().files.png[chunk(print.main().files.png, "IHDR") + 9], 6) << "RGBA";
  const int middle = image.width / 2;
  EXPECT_NEAR(image.at(middle, middle, 0), 200, 1);
  EXPECT_NEAR(image.at(middle, middle, 1), 100, 1);
  EXPECT_NEAR(image.at(middle, middle, 2), 10, 1);
  EXPECT_NEAR(image.at(middle, middle, 3), 128, 1);
  EXPECT_EQ(image.at(10, 10, 3), 0);
}

TEST(Print, TellsHowMuchInkFallsOffTheChart) {
  Sample x = hand_made::flat(80, 20);
  x.settings.print.marks = false;
  // A bar through the middle; the sheet covers 80 of its 100 mm.
  const Pattern pattern = svg_pattern("<rect x='-50' y='-1' width='100' height='2'/>", 110, x.settings);
  const Print print = print_of(x, pattern);
  EXPECT_NEAR(pattern.ink_mm2(), 200, 0.5);
  EXPECT_NEAR(print.main().ink_printed, 0.8, 0.002);
  ASSERT_EQ(print.warnings.size(), 1u);
  EXPECT_EQ(print.warnings[0].code, "ink-off-chart");
  EXPECT_TRUE(print.warnings[0].text.ends_with(
      " % of the drawing's ink lies off the formed part and is not printed."));
  EXPECT_NEAR(std::stod(print.warnings[0].text), 20, 0.2);

  const auto none = try_print(x, svg_pattern("<circle cx='70' r='5'/>", 160, x.settings));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::unusable_pattern);
  EXPECT_EQ(none.error().text(),
            "none of the drawing's ink falls onto the formed part (pattern.offset_mm); move it nearer to "
            "the top of the mold, or give a smaller pattern.width_mm");
}

TEST(Print, DrawsTheMoldsOutlineAlsoWhereTheDrawingCrossesIt) {
  const Sample x = hand_made::flat(200, 40, 60);
  const Print print =
      print_of(x, svg_pattern("<rect x='-60' y='-1' width='120' height='2'/>", 125, x.settings));
  EXPECT_NE(print.main().files.svg.find("mark-mold-outline"), std::string::npos);
  EXPECT_EQ(print.main().ink_on_head,
            print.main().ink_printed);  // a picture on the chart is printed only there
}

TEST(Print, ReturnsToTheDrawingThroughTheFormedPart) {
  // Round trip over a dome: a viewer of the formed print sees the drawing. Every point of the drawing is looked up at
  // its position on the sheet (known in closed form for this dome) and compared.
  Sample x = hand_made::dome(60);
  x.settings.print.marks = false;
  const Pattern pattern = pattern_of(ring_file("rings-7x40mm.svg"), x.settings);
  const Print print = print_of(x, pattern);
  const Decoded image = decode_png(print.main().files.png);
  const double shrink = 70 / (60 * 80 * M_PI / 180);  // from the chart's radius to the sheet's
  int both = 0, either = 0;
  for (double v = -50; v <= 50; v += 0.2)
    for (double u = -55; u <= 55; u += 0.2) {
      const Eigen::Vector2d st = shrink * Eigen::Vector2d(u, v), at = print.picture_uv(st);
      const int i = static_cast<int>(at.x() * image.width), j = static_cast<int>((1 - at.y()) * image.height);
      const bool wanted = pattern.sample({u, v}, 0.05).coverage() > 0.5, printed = image.at(i, j) < 128;
      both += wanted && printed;
      either += wanted || printed;
    }
  EXPECT_GT(either, 10000);
  EXPECT_GE(static_cast<double>(both) / either, 0.97);
}

TEST(Print, MarksKeepOffThePatternAndTheMargin) {
  Sample x = hand_made::flat(200, 40, 60);
  x.settings.print.margin_mm = 5;
  x.settings.print.marks = false;
  const Pattern pattern =
      svg_pattern("<circle r='30' fill='none' stroke='#000' stroke-width='2'/>", 70, x.settings);
  const Decoded bare = decode_png(print_of(x, pattern).main().files.png);
  x.settings.print.marks = true;
  const Print marked = print_of(x, pattern);
  const Decoded image = decode_png(marked.main().files.png);
  int added = 0, outline = 0;
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      const double s = (i + 0.5 - 0.5 * image.width) * marked.grid.pixel_mm,
                   t = (0.5 * image.height - j - 0.5) * marked.grid.pixel_mm;
      if (image.at(i, j) == bare.at(i, j)) continue;
      ++added;
      // Except for the mold's outline, between the pattern and the marks.
      if (std::hypot(s, t) > 50 && std::hypot(s, t) < 60.2) {
        ++outline;
        continue;
      }
      EXPECT_GT(std::max(std::abs(s), std::abs(t)), 80) << s << ", " << t;
      EXPECT_LT(std::max(std::abs(s), std::abs(t)), 95.2) << s << ", " << t;
    }
  EXPECT_GT(added, 5000);
  // Half of 4 x 120 mm is dashed, in lines of about two pixels.
  EXPECT_NEAR(outline, 240 / marked.grid.pixel_mm * 2, 240 / marked.grid.pixel_mm);
  EXPECT_TRUE(marked.warnings.empty());
}

TEST(Print, AMarkThatWouldLieOnThePatternIsLeftOutAndNamed) {
  const Sample x = hand_made::flat(100, 20);  // the chart is the whole sheet
  const Print print = print_of(x, svg_pattern("<circle r='30'/>", 70, x.settings));
  ASSERT_EQ(print.warnings.size(), 1u);
  EXPECT_EQ(print.warnings[0].code, "marks-left-out");
  EXPECT_NE(print.warnings[0].text.find("ruler"), std::string::npos);
  EXPECT_EQ(print.ruler_mm, std::nullopt);
  ASSERT_TRUE(print.warnings[0].figure);
  EXPECT_EQ(print.warnings[0].figure->value,
            1.0 + static_cast<double>(
                      std::count(print.warnings[0].text.begin(), print.warnings[0].text.end(), ',')));
}

TEST(Print, TheLegendIsWrappedOnANarrowSheet) {
  Sample x = hand_made::flat(100, 40, 25);
  const Print print = print_of(x, svg_pattern("<circle r='10'/>", 30, x.settings));
  EXPECT_TRUE(print.warnings.empty());
  pugi::xml_document svg;
  ASSERT_TRUE(svg.load_string(print.main().files.svg.c_str()));
  const auto marks = svg.child("svg").find_child_by_attribute("g", "id", "marks");
  std::vector<std::string> legend;
  for (const auto& text : marks.find_child_by_attribute("g", "id", "mark-legend").children("text")) {
    legend.push_back(text.child_value());
    EXPECT_STREQ(text.attribute("font-size").value(), "2.4");
  }
  EXPECT_EQ(legend,
            (std::vector<std::string>{"outer face, seen from above   ·   scale 1:1, check with the ruler",
                                      "Vacuform 3f9a12c4   ·   sheet 100 × 100 × 1 mm PETG",
                                      "frame 3 mm inside the sheet's edge"}));
  x.settings.print.margin_mm = 40;
  const Print bare = print_of(x, svg_pattern("<circle r='10'/>", 30, x.settings));
  ASSERT_EQ(bare.warnings.size(), 1u);
  EXPECT_EQ(bare.warnings[0].text,
            "print.margin_mm leaves no room for marks on this sheet; none are printed.");
}

// The only <image> of a print's SVG, decoded.
Decoded embedded(const pugi::xml_document& svg) {
  const std::string href = svg.child("svg")
                               .find_node([](const auto& n) { return std::string(n.name()) == "image"; })
                               .attribute("xlink:href")
                               .value();
  const std::string head = "data:image/png;base64,";
  EXPECT_TRUE(href.starts_with(head));
  gsize size = 0;
  guchar* data = g_base64_decode(href.c_str() + head.size(), &size);
  const Decoded out = decode_png({data, size});
  g_free(data);
  return out;
}

TEST(Print, TheSvgIsTheSamePrintAtOneToOne) {
  for (const InkedFace face : {InkedFace::outer, InkedFace::inner}) {
    Sample x = hand_made::flat(200, 40, 60);
    x.settings.sheet.height_mm = 180;
    x.settings.machine.window_height_mm = 160;
    x.settings.pattern.inked_face = face;
    const Print print = print_of(x, svg_pattern("<path d='M0,0 L30,0 L30,10 Z'/>", 70, x.settings));
    pugi::xml_document svg;
    ASSERT_TRUE(svg.load_string(print.main().files.svg.c_str()));
    const pugi::xml_node root = svg.child("svg");
    EXPECT_STREQ(root.attribute("width").value(), "200.000mm");
    EXPECT_STREQ(root.attribute("height").value(), "180.000mm");
    EXPECT_STREQ(root.attribute("viewBox").value(), "-100.000 -90.000 200.000 180.000");
    EXPECT_STREQ(root.child_value("title"), "Vacuform print 3f9a12c4");
    const pugi::xml_node pattern = root.find_child_by_attribute("g", "id", "pattern");
    const pugi::xml_node marks = root.find_child_by_attribute("g", "id", "marks");
    EXPECT_STREQ(pattern.attribute("transform").value(), face == InkedFace::inner ? "scale(-1 1)" : "");
    const std::string legend = marks.find_child_by_attribute("g", "id", "mark-legend").child_value("text");
    EXPECT_EQ(legend, std::string(face == InkedFace::inner
                                      ? "inner face, MIRRORED: print on the side that touches the mold"
                                      : "outer face, seen from above") +
                          "   ·   scale 1:1, check with the ruler");

    // Its picture is the chart's part of print.png, in the same position.
    const Decoded part = embedded(svg), whole = decode_png(print.main().files.png);
    const pugi::xml_node image = pattern.child("image");
    const double left = image.attribute("x").as_double(), top = image.attribute("y").as_double();
    EXPECT_NEAR(image.attribute("width").as_double(), part.width * print.grid.pixel_mm, 1e-5);
    const int i0 = static_cast<int>(std::lround(left / print.grid.pixel_mm + 0.5 * whole.width));
    const int j0 = static_cast<int>(std::lround(top / print.grid.pixel_mm + 0.5 * whole.height));
    for (int j = 0; j < part.height; ++j)
      for (int i = 0; i < part.width; ++i) {
        // The mold's outline is a mark, at 55 mm and more.
        if (std::hypot(i0 + i - 0.5 * whole.width, j0 + j - 0.5 * whole.height) * print.grid.pixel_mm > 50)
          continue;
        const int column = face == InkedFace::inner ? whole.width - 1 - (i0 + i) : i0 + i;
        ASSERT_EQ(part.at(i, j), whole.at(column, j0 + j));
      }
    // The ruler has the length that it states.
    const std::string baseline =
        marks.find_child_by_attribute("g", "id", "mark-ruler").child("path").attribute("d").value();
    EXPECT_TRUE(baseline.starts_with("M-50.000,")) << baseline;
    EXPECT_NE(baseline.find(" L50.000,"), std::string::npos) << baseline;
    EXPECT_EQ(print.ruler_mm, 100);
  }
}

TEST(Print, TheSvgLooksLikeThePng) {
  // Rendered by librsvg, including marks and texts, both mirrored and not.
  for (const InkedFace face : {InkedFace::outer, InkedFace::inner}) {
    Sample made = hand_made::flat(200, 40, 60);
    made.settings.pattern.inked_face = face;
    const Print print = print_of(made, svg_pattern("<path d='M0,0 L30,0 L30,10 Z'/>", 70, made.settings));
    const Decoded image = decode_png(print.main().files.png);
    const auto drawn = Pattern::read(bytes_of(print.main().files.svg), "print.svg", PatternSettings{}, 300);
    ASSERT_TRUE(drawn) << drawn.error().text();
    // In blocks of a third of a millimetre: edges may be drawn slightly softer, but everything is in its position. The
    // texts at the front and back are spaced by other rules there.
    const int strip = static_cast<int>(10 / print.grid.pixel_mm);
    constexpr int block = 4;
    double differing = 0, inked = 0;
    for (int j = strip; j + block <= image.height - strip; j += block)
      for (int i = 0; i + block <= image.width; i += block) {
        double png = 0, svg = 0;
        for (int y = j; y < j + block; ++y)
          for (int x = i; x < i + block; ++x) {
            const Eigen::Vector2d at((x + 0.5 - 0.5 * image.width) * print.grid.pixel_mm,
                                     (0.5 * image.height - y - 0.5) * print.grid.pixel_mm);
            png += 1 - image.at(x, y) / 255.0;
            svg += drawn->sample(at, 0).coverage();
          }
        inked += png;
        differing += std::abs(png - svg);
      }
    EXPECT_GT(inked, 20'000);
    EXPECT_LT(differing / inked, 0.05);
  }
}

TEST(Print, ALabelCannotBreakTheSvg) {
  const Sample x = hand_made::flat(200, 20, 60);
  const Pattern pattern = svg_pattern("<circle r='30'/>", 70, x.settings);
  const std::string hostile = "</text><script>&\"\n\xff";
  for (const PrintLabel& label : {PrintLabel{hostile}, PrintLabel{"3f9a12c4", hostile}}) {
    const auto print = try_print(x, pattern, label);
    ASSERT_TRUE(print);
    pugi::xml_document svg;
    ASSERT_TRUE(svg.load_string(print->main().files.svg.c_str()));
    EXPECT_FALSE(svg.find_node([](const auto& n) { return std::string(n.name()) == "script"; }));
  }
}

std::string legend_of(const Print& print) {
  pugi::xml_document svg;
  EXPECT_TRUE(svg.load_string(print.main().files.svg.c_str()));
  const auto legend =
      svg.find_node([](const auto& n) { return std::string(n.attribute("id").value()) == "mark-legend"; });
  std::string text;
  for (const auto& line : legend.children("text")) text += std::string(line.child_value()) + "\n";
  return text;
}

TEST(Print, SaysTheReferenceOfTheJob) {
  const Sample x = hand_made::flat(200, 20, 60);
  const Pattern pattern = svg_pattern("<circle r='30'/>", 70, x.settings);
  const Print without = print_of(x, pattern);
  const auto print = try_print(x, pattern, {"3f9a12c4", "Köln (2) <&> \\ 7"});
  ASSERT_TRUE(print);
  pugi::xml_document svg;
  ASSERT_TRUE(svg.load_string(print->main().files.svg.c_str()));
  EXPECT_STREQ(svg.child("svg").child_value("title"), "Vacuform print 3f9a12c4, reference Köln (2) <&> \\ 7");
  EXPECT_NE(legend_of(*print).find("reference Köln (2) <&> \\ 7   ·   Vacuform 3f9a12c4"), std::string::npos)
      << legend_of(*print);
  EXPECT_EQ(legend_of(without).find("reference"), std::string::npos);
  EXPECT_NE(print->main().files.png, without.main().files.png);
  EXPECT_NE(print->main().files.pdf, without.main().files.pdf);
  EXPECT_EQ(print->warnings.size(), without.warnings.size());
}

TEST(Print, WarnsOfCharactersThatItsFontsLack) {
  const Sample x = hand_made::flat(200, 20, 60);
  const Pattern pattern = svg_pattern("<circle r='30'/>", 70, x.settings);
  const auto print = try_print(x, pattern, {"3f9a12c4", "北京 12 ü"});
  ASSERT_TRUE(print);
  EXPECT_NE(legend_of(*print).find("reference ?? 12 ü "), std::string::npos) << legend_of(*print);
  const auto warning = std::find_if(print->warnings.begin(), print->warnings.end(),
                                    [](const Warning& w) { return w.code == "reference-incomplete"; });
  ASSERT_NE(warning, print->warnings.end());
  EXPECT_EQ(warning->figure->value, 2);
}

TEST(Print, GivesTheSameBytesTwice) {
  const Sample x = hand_made::dome(40);
  for (const char* colour : {"#000", "#a40"}) {
    const std::string body =
        std::string("<circle r='30' fill='none' stroke-width='3' stroke='") + colour + "'/>";
    const Print a = print_of(x, svg_pattern(body, 70, x.settings)),
                b = print_of(x, svg_pattern(body, 70, x.settings));
    EXPECT_EQ(a.main().files.png, b.main().files.png);
    EXPECT_EQ(a.main().files.svg, b.main().files.svg);
    EXPECT_EQ(a.main().files.pdf, b.main().files.pdf);
  }
}

TEST(Print, RefusesMorePixelsThanItCanDraw) {
  Sample x = hand_made::flat(1500, 10);
  x.settings.print.dpi = 1200;
  const auto print = try_print(x, svg_pattern("<circle r='5'/>", 20, x.settings));
  ASSERT_FALSE(print);
  EXPECT_EQ(print.error().code, Code::too_large);
  EXPECT_EQ(print.error().text(),
            "the print would have 70867 x 70867 pixels (print.dpi); give print.dpi of at most 541");
}

TEST(Print, CanBeCancelled) {
  const Sample x = hand_made::flat(100, 10);
  Context context;
  context.cancel();
  const auto print = try_print(x, svg_pattern("<circle r='5'/>", 20, x.settings), {""}, context);
  ASSERT_FALSE(print);
  EXPECT_EQ(print.error().code, Code::cancelled);
}

TEST(Print, ReportsProgressThatNeverFalls) {
  const Sample x = hand_made::flat(100, 10);
  double last = -1;
  const Context context([&](Stage stage, double fraction) {
    EXPECT_EQ(stage, Stage::printing);
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  ASSERT_TRUE(try_print(x, svg_pattern("<circle r='5'/>", 20, x.settings), {""}, context));
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace vacuform
