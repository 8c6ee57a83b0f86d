// The files of a print made of lines: their content, and that they show the same.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <iterator>
#include <pugixml.hpp>
#include <regex>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "tests/unit/fixtures/ring_files.hpp"
#include "worker/pattern/ink_parts.hpp"
#include "worker/printing/print.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;
using hand_made::Sample;

struct Made {
  Pattern pattern;
  std::optional<Drawing> drawing;
  Placement placement;
  Print print;
};
Print print_of(const Sample& x, const Placement& placement, std::shared_ptr<const LayerSource> source) {
  auto print = make_print(
      {.charted = hand_made::Charted(x),
       .placement = placement,
       .settings = x.settings,
       .label = {"3f9a12c4"},
       .layers = {{.name = "print", .face = x.settings.pattern.inked_face, .source = std::move(source)}}},
      Context());
  if (!print) throw std::runtime_error(print.error().text());
  return *std::move(print);
}
Made make(const Sample& x, const Bytes& bytes, bool as_lines = true) {
  auto pattern = Pattern::read(bytes, "drawing", x.settings.pattern, x.settings.print.dpi);
  if (!pattern) throw std::runtime_error(pattern.error().text());
  std::vector<Warning> warnings;
  std::optional<Drawing> drawing;
  if (as_lines) drawing = read_drawing(*pattern, warnings);
  const Drawing* lines = drawing ? &*drawing : nullptr;
  auto placement = place(hand_made::Charted(x), lines, x.settings, Context());
  if (!placement) throw std::runtime_error(placement.error().text());
  const auto source = lines ? *drawing_layer(*pattern, *lines, *placement, x.settings, Context())
                            : picture_layer(*pattern, *placement, nullptr, x.settings.print.compensate_ink);
  auto print = print_of(x, *placement, source);
  return {std::move(*pattern), std::move(drawing), std::move(*placement), std::move(print)};
}
Bytes page(const std::string& body, double side = 70) {
  const std::string mm = std::to_string(side), half = std::to_string(-side / 2);
  return bytes_of(std::string("<svg xmlns='http://www.w3.org/2000/svg' width='") + mm + "mm' height='" + mm +
                  "mm' viewBox='" + half + " " + half + " " + mm + " " + mm + "'>" + body + "</svg>");
}

const std::string two_coils =
    "<g id='left &amp; \"1\"'><circle cx='-12' r='9' fill='none' stroke='#000' stroke-width='2'/></g>"
    "<path d='M-2 0H2' stroke='#000' stroke-width='1'/>"
    "<g id='pattern'><circle cx='12' r='9' fill='none' stroke='#000' stroke-width='2'/><circle cx='12' "
    "r='2'/></g>";

TEST(PrintFiles, TheSvgHasThePatternsElementsAsLines) {
  Sample x = hand_made::flat(200, 40, 60);
  x.settings.pattern.placement = PatternPlacement::chart;
  const Made made = make(x, page(two_coils));
  pugi::xml_document svg;
  ASSERT_TRUE(svg.load_string(made.print.main().files.svg.c_str()));
  EXPECT_FALSE(svg.find_node([](const auto& n) { return std::string(n.name()) == "image"; }));
  const auto layer = svg.child("svg").find_child_by_attribute("g", "id", "pattern-layer");
  std::vector<std::string> ids;
  for (const auto& g : layer.children("g")) ids.push_back(g.attribute("id").value());
  EXPECT_EQ(ids, (std::vector<std::string>{"left & \"1\"", "", "pattern"}));
  const auto coil = layer.child("g");
  std::vector<std::string> classes;
  for (const auto& path : coil.children("path")) classes.push_back(path.attribute("class").value());
  EXPECT_EQ(classes, (std::vector<std::string>{"", "centreline"}));
  EXPECT_STREQ(coil.child("path").attribute("fill").value(), "#000000");
  const auto centre = coil.last_child();
  EXPECT_STREQ(centre.attribute("stroke").value(), "none");
  EXPECT_STREQ(centre.attribute("data-width-mm").value(), "2");
  EXPECT_TRUE(std::string(centre.attribute("d").value()).ends_with("Z"));
  EXPECT_TRUE(svg.child("svg").find_child_by_attribute("g", "id", "marks"));
  EXPECT_EQ(made.print.main().source->vectors()->elements.size(), 3u);
  EXPECT_NEAR(made.print.main().ink_printed, 1, 1e-12);
}

// The share of blocks of a third of a millimetre whose ink differs. The strips at the front and back are skipped: texts
// are spaced by other rules there.
double difference(const Print& print, const Pattern& drawn) {
  const Decoded image = decode_png(print.main().files.png);
  const int strip = static_cast<int>(10 / print.grid.pixel_mm);
  constexpr int block = 4;
  double differing = 0, inked = 0;
  for (int j = strip; j + block <= image.height - strip; j += block)
    for (int i = 0; i + block <= image.width; i += block) {
      double png = 0, other = 0;
      for (int y = j; y < j + block; ++y)
        for (int x = i; x < i + block; ++x) {
          png += (255 - image.at(x, y, 1)) / 255.0 * image.at(x, y, 3) / 255.0;
          other += drawn
                       .sample({(x + 0.5 - 0.5 * image.width) * print.grid.pixel_mm,
                                (0.5 * image.height - y - 0.5) * print.grid.pixel_mm},
                               0)
                       .coverage();
        }
      inked += png;
      differing += std::abs(png - other);
    }
  return differing / inked;
}

TEST(PrintFiles, TheSvgLooksLikeThePng) {
  Sample x = hand_made::flat(200, 40, 60);
  x.settings.pattern.inked_face = InkedFace::inner;
  x.settings.pattern.placement = PatternPlacement::chart;
  const Made made = make(x, page(two_coils + "<path id='tip' d='M0 10L30 10 30 20Z'/>"));
  const auto drawn =
      Pattern::read(bytes_of(made.print.main().files.svg), "print.svg", PatternSettings{}, 300);
  ASSERT_TRUE(drawn) << drawn.error().text();
  EXPECT_LT(difference(made.print, *drawn), 0.05);
}

TEST(PrintFiles, LinesAndPixelsShowTheSame) {
  Sample x = hand_made::dome(40);
  x.settings.print.marks = false;
  x.settings.print.dpi = 200;
  x.settings.pattern.placement = PatternPlacement::chart;
  const Decoded lines = decode_png(make(x, ring_file("rings-7x40mm.svg")).print.main().files.png),
                pixels = decode_png(make(x, ring_file("rings-7x40mm.svg"), false).print.main().files.png);
  ASSERT_EQ(lines.width, pixels.width);
  double differing = 0, inked = 0;
  for (int j = 0; j < lines.height; ++j)
    for (int i = 0; i < lines.width; ++i) {
      inked += 255 - pixels.at(i, j);
      differing += std::abs(lines.at(i, j) - pixels.at(i, j));
    }
  EXPECT_LT(differing / inked, 0.05);
}

TEST(PrintFiles, ColoursAndOpacitiesAreKept) {
  Sample x = hand_made::flat(100, 10, 40);
  x.settings.print.marks = false;
  x.settings.print.background = Background::transparent;
  const Made made =
      make(x, page("<rect x='-10' y='-10' width='20' height='20' fill='#c8640a' fill-opacity='0.5'/>"));
  const Decoded image = decode_png(made.print.main().files.png);
  const int middle = image.width / 2;
  EXPECT_NEAR(image.at(middle, middle, 0), 200, 2);
  EXPECT_NEAR(image.at(middle, middle, 1), 100, 2);
  EXPECT_NEAR(image.at(middle, middle, 2), 10, 2);
  EXPECT_NEAR(image.at(middle, middle, 3), 128, 1);
  EXPECT_EQ(image.at(10, 10, 3), 0);
  EXPECT_NE(made.print.main().files.svg.find("fill=\"#c8640a\" fill-opacity=\"0.5\""), std::string::npos);
}

// Round trip: a viewer of the formed print sees the drawing. The dome's map from chart to sheet is known.
TEST(PrintFiles, ReturnsToTheDrawingThroughTheFormedPart) {
  Sample x = hand_made::dome(100);
  x.settings.print.marks = false;
  x.settings.pattern.placement = PatternPlacement::chart;
  const Made made = make(x, ring_file("rings-7x40mm.svg"));
  const Decoded image = decode_png(made.print.main().files.png);
  const double shrink = 70 / (60 * 80 * M_PI / 180);  // from the chart's radius to the sheet's
  int both = 0, either = 0;
  for (double v = -50; v <= 50; v += 0.2)
    for (double u = -55; u <= 55; u += 0.2) {
      const Vector2d at = made.print.picture_uv(shrink * Vector2d(u, v));
      const int i = static_cast<int>(at.x() * image.width), j = static_cast<int>((1 - at.y()) * image.height);
      const bool wanted = made.pattern.sample({u, v}, 0.05).coverage() > 0.5, printed = image.at(i, j) < 128;
      both += wanted && printed;
      either += wanted || printed;
    }
  EXPECT_GT(either, 10000);
  EXPECT_GE(static_cast<double>(both) / either, 0.98);
}

TEST(PrintFiles, EachPartOfAPictureIsPrintedThroughItsOwnPatch) {
  Sample x = hand_made::flat(120, 24);
  x.settings.print.marks = false;
  x.settings.print.dpi = 254;
  // Two squares of 8 mm, 20 mm apart.
  const auto gray = [](int i, int j) {
    return (i / 10 % 20) > 5 && (i / 10 % 20) < 14 && j > 160 && j < 240 ? 0 : 255;
  };
  const auto pattern = Pattern::read(gray_png(400, 400, 10000, gray), "two.png", x.settings.pattern, 254);
  const InkParts parts(*pattern);
  ASSERT_EQ(parts.drawing().elements.size(), 2u);
  auto placement = *place(hand_made::Charted(x), nullptr, x.settings, Context());
  for (int part = 0; part < 2; ++part) {
    PlacedElement placed;
    placed.element = part;
    placed.patch = placement.charts[0].patch;
    // The first moves 7 mm up, the second 7 mm down.
    for (Vector2d& st : placed.patch.rest) st.y() += part == 0 ? 7 : -7;
    placement.elements.push_back(placed);
  }
  const Print print = print_of(x, placement, picture_layer(*pattern, placement, &parts, false));
  const Decoded image = decode_png(print.main().files.png);
  Vector2d sums[2]{{0, 0}, {0, 0}};
  double inks[2]{0, 0};
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      const double ink = (255 - image.at(i, j)) / 255.0;
      const Vector2d st((i + 0.5 - 0.5 * image.width) * 0.1, (0.5 * image.height - j - 0.5) * 0.1);
      const int side = st.x() > 0 ? 1 : 0;
      sums[side] += ink * st;
      inks[side] += ink;
    }
  EXPECT_LT((sums[0] / inks[0] - Vector2d(-10, 7)).norm(), 0.1);
  EXPECT_LT((sums[1] / inks[1] - Vector2d(10, -7)).norm(), 0.1);
  EXPECT_NEAR(inks[0], 8.0 * 7.9 * 100, 20);
  EXPECT_NEAR(inks[1], inks[0], 1);
}

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

// The content of the page, inflated.
std::string content_of(const std::string& pdf) {
  std::smatch found;
  if (!std::regex_search(pdf, found, std::regex("/Contents (\\d+) 0 R"))) return {};
  const auto object = pdf.find(std::string("\n") + found[1].str() + " 0 obj");
  const auto begin = pdf.find("stream\n", object) + 7, end = pdf.find("\nendstream", begin);
  std::string out(1 << 22, '\0');
  uLongf size = out.size();
  if (uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                 reinterpret_cast<const Bytef*>(pdf.data() + begin), end - begin) != Z_OK)
    return {};
  out.resize(size);
  return out;
}

TEST(PrintFiles, ThePdfIsAPageOfTheSheetWithLinesAndTexts) {
  Sample x = hand_made::flat(200, 40, 60);
  x.settings.sheet.height_mm = 180;
  x.settings.machine.window_height_mm = 160;
  x.settings.pattern.placement = PatternPlacement::chart;
  for (const InkedFace face : {InkedFace::outer, InkedFace::inner}) {
    x.settings.pattern.inked_face = face;
    const Made made = make(x, page(two_coils));
    const std::string pdf = text_of(made.print.main().files.pdf);
    std::smatch box;
    ASSERT_TRUE(std::regex_search(pdf, box, std::regex("/MediaBox \\[0 0 ([0-9.]+) ([0-9.]+)\\]")));
    EXPECT_NEAR(std::stod(box[1]), 200 * 72 / 25.4, 1e-6);
    EXPECT_NEAR(std::stod(box[2]), 180 * 72 / 25.4, 1e-6);
    EXPECT_EQ(pdf.find("/Image"), pdf.npos);
    EXPECT_EQ(pdf.find("Date"), pdf.npos);
    const std::string content = content_of(pdf);
    // Four painted areas.
    const std::regex black("0 g\n");
    EXPECT_EQ(
        std::distance(std::sregex_iterator(content.begin(), content.end(), black), std::sregex_iterator()),
        4);
    EXPECT_EQ(content.find("-1 0 0 1 0 0 cm") != content.npos, face == InkedFace::inner);
    EXPECT_NE(content.find("(Vacuform 3f9a12c4   \xb7   sheet 200 \xd7 180 \xd7 1 mm PETG"), content.npos);
    // Every object is at the offset that the table gives.
    const auto table = static_cast<std::size_t>(std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10)));
    std::istringstream lines(pdf.substr(table));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "xref");
    std::getline(lines, line);
    std::getline(lines, line);
    for (int object = 1; std::getline(lines, line) && line.ends_with("n "); ++object)
      EXPECT_EQ(pdf.substr(std::stoul(line), 8).find(std::to_string(object) + " 0 obj"), 0u) << line;
  }
}

TEST(PrintFiles, ThePdfOfAPictureHasItsRows) {
  Sample x = hand_made::flat(100, 10, 40);
  x.settings.print.marks = false;
  x.settings.print.dpi = 100;
  for (const char* colour : {"#444", "#c8640a"}) {
    const Made made = make(
        x, page(std::string("<rect x='-10' y='-10' width='20' height='20' fill='") + colour + "'/>"), false);
    const std::string pdf = text_of(made.print.main().files.pdf);
    const bool gray = made.pattern.grayscale();
    EXPECT_EQ(pdf.find("/SMask") == pdf.npos, gray);
    const auto at = pdf.find(gray ? "/ColorSpace /DeviceGray" : "/ColorSpace /DeviceRGB");
    ASSERT_NE(at, pdf.npos);
    std::smatch found;
    const std::string head = pdf.substr(pdf.rfind("/Width", at), 400);
    ASSERT_TRUE(std::regex_search(head, found, std::regex("/Width (\\d+) /Height (\\d+)")));
    const std::size_t width = std::stoul(found[1]), height = std::stoul(found[2]), channels = gray ? 1 : 3;
    const auto begin = pdf.find("stream\n", at) + 7, end = pdf.find("\nendstream", begin);
    Bytes rows(height * (1 + width * channels));
    uLongf size = rows.size();
    ASSERT_EQ(uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(pdf.data() + begin), end - begin),
              Z_OK);
    ASSERT_EQ(size, rows.size());
    // Each row begins with its filter (RFC 2083, 6): as it is, or as the difference from the row above.
    std::uint8_t middle = 0;
    for (std::size_t y = 0; y <= height / 2; ++y) {
      const std::uint8_t* const row = &rows[y * (1 + width * channels)];
      ASSERT_TRUE(row[0] == 0 || row[0] == 2);
      middle = static_cast<std::uint8_t>(row[1 + width / 2 * channels] + (row[0] == 2 ? middle : 0));
    }
    EXPECT_EQ(middle, gray ? 0x44 : 0xc8);
  }
}

TEST(PrintFiles, RepeatTheirBytes) {
  Sample x = hand_made::dome(40);
  const Made a = make(x, ring_file("rings-7x40mm.svg")), b = make(x, ring_file("rings-7x40mm.svg"));
  EXPECT_EQ(a.print.main().files.png, b.print.main().files.png);
  EXPECT_EQ(a.print.main().files.svg, b.print.main().files.svg);
  EXPECT_EQ(a.print.main().files.pdf, b.print.main().files.pdf);
}

TEST(PrintFiles, ShadesAreKeptWhereTheSheetStretches) {
  // Left of the middle the sheet keeps its size; right of it the sheet is stretched to 1.6 times its area.
  Sample x = hand_made::grid(120, 24);
  x.settings.print.marks = false;
  x.settings.print.compensate_ink = true;
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i)
    x.sheet.formed[i].x() = x.sheet.rest[i].x() * (x.sheet.rest[i].x() > 0 ? 1.6 : 1);
  hand_made::lay_chart(x, 1e9,
                       [](const Vector2d& st) { return Vector2d(st.x() * (st.x() > 0 ? 1.6 : 1), st.y()); });
  const auto left_and_right = [&](int gray) {
    const Made made = make(x, gray_png(600, 600, 10000, [&](int, int) { return gray; }));
    const Decoded image = decode_png(made.print.main().files.png);
    EXPECT_TRUE(made.print.warnings.empty());
    const int j = image.height / 2, i = static_cast<int>(10 / made.print.grid.pixel_mm);
    return std::pair(255 - image.at(image.width / 2 - i, j), 255 - image.at(image.width / 2 + i, j));
  };
  const auto [light_left, light_right] = left_and_right(255 - 100);
  EXPECT_NEAR(light_left, 100, 1);
  EXPECT_NEAR(light_right, 160, 1);
  // Nothing can be darker than full ink, so everything is lightened by the same factor.
  const auto [dark_left, dark_right] = left_and_right(255 - 200);
  EXPECT_NEAR(dark_right, 255, 1);
  EXPECT_NEAR(dark_left, 255 / 1.6, 1);
  const Made black = make(x, gray_png(600, 600, 10000, [&](int i, int) { return i % 100 < 50 ? 0 : 255; }));
  ASSERT_EQ(black.print.warnings.size(), 1u);
  EXPECT_EQ(black.print.warnings[0].code, "ink-not-compensated");
}

}  // namespace
}  // namespace vacuform
