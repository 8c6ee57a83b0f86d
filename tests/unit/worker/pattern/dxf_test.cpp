// Drawings from CAD programs: lines, arcs, splines and blocks of a DXF.
#include <gtest/gtest.h>

#include <cmath>

#include "api/redaction/redaction.hpp"
#include "tests/unit/fixtures/drawing_files.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/drawing.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

// "8=0 10=1.5" as groups.
std::string groups(const std::string& words) {
  std::string out;
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size()), sign = words.find('=', at);
    out += words.substr(at, sign - at) + "\n" + words.substr(sign + 1, end - sign - 1) + "\n";
    at = end + 1;
  }
  return out;
}
std::string dxf_file(const std::string& entities, int units = 4, const std::string& blocks = "",
                     const std::string& layers = "") {
  return groups("0=SECTION 2=HEADER 9=$ACADVER 1=AC1027 9=$INSUNITS 70=" + std::to_string(units) +
                " 0=ENDSEC") +
         groups("0=SECTION 2=TABLES 0=TABLE 2=LAYER 70=1") + groups(layers) + groups("0=ENDTAB 0=ENDSEC") +
         groups("0=SECTION 2=BLOCKS") + groups(blocks) + groups("0=ENDSEC 0=SECTION 2=ENTITIES") +
         groups(entities) + groups("0=ENDSEC 0=EOF");
}

struct DxfRead {
  Pattern pattern;
  Drawing drawing;
};
PatternSettings lines_of(double mm, std::optional<double> width_mm = {}) {
  PatternSettings settings;
  settings.line_mm = mm;
  settings.width_mm = width_mm;
  return settings;
}
// As it is, and as the server stores it: the same lines.
Result<DxfRead> read_dxf(const std::string& text, const PatternSettings& settings = lines_of(1)) {
  VACUFORM_TRY(pattern, Pattern::read(bytes_of(text), "c.dxf", settings, 300));
  std::vector<Warning> warnings;
  auto drawing = read_drawing(pattern, warnings);
  EXPECT_TRUE(drawing && warnings.empty());
  Bytes copy = bytes_of(text);
  EXPECT_TRUE(redact(copy, "c.dxf"));
  const auto stored = Pattern::read(copy, "c.dxf", settings, 300);
  EXPECT_TRUE(stored) << stored.error().text();
  if (stored) {
    EXPECT_EQ(stored->size_mm(), pattern.size_mm());
    EXPECT_NEAR(stored->ink_mm2(), pattern.ink_mm2(), 1e-9);
  }
  Bytes twice = copy;
  EXPECT_TRUE(redact(twice, "c.dxf"));
  EXPECT_EQ(twice, copy);
  EXPECT_EQ(std::count(copy.begin(), copy.end(), '\n'), std::count(text.begin(), text.end(), '\n'));
  return DxfRead{std::move(pattern), *std::move(drawing)};
}
std::string refusal_of(const std::string& text, const PatternSettings& settings = lines_of(1)) {
  const auto pattern = Pattern::read(bytes_of(text), "c.dxf", settings, 300);
  return pattern ? "" : pattern.error().text();
}
double length_mm(const Drawing& drawing) {
  double sum = 0;
  for (const Element& e : drawing.elements)
    for (const Shape& s : e.shapes)
      for (const Curve& c : s.curves) sum += flatten(c, {}).back().along;
  return sum;
}
std::size_t lines_in(const Drawing& drawing) {
  std::size_t count = 0;
  for (const Element& e : drawing.elements)
    for (const Shape& s : e.shapes) count += s.curves.size();
  return count;
}

TEST(Dxf, MeasuresEveryKindOfLine) {
  struct Case {
    const char* entities;
    double length;
    Vector2d size;  // of the centre lines
  };
  // A square of 90 degrees as a rational spline of second degree: a quarter of a circle of radius 7.
  for (const auto& c : {
           Case{"0=LINE 8=0 10=-3 20=4 11=9 21=9", 13, {12, 5}},
           Case{"0=CIRCLE 8=0 10=13 20=-7 40=21.5", 2 * M_PI * 21.5, {43, 43}},
           Case{"0=ARC 8=0 10=13 20=-7 40=20 50=300 51=60", M_PI * 40 / 3, {10, 40 * std::sin(M_PI / 3)}},
           Case{
               "0=ELLIPSE 8=0 10=5 20=5 11=0 21=20 40=0.5 41=0 42=6.283185307179586", 96.884482205, {20, 40}},
           Case{"0=LWPOLYLINE 8=0 90=4 70=1 10=0 20=0 10=30 20=0 10=30 20=40 10=0 20=40", 140, {30, 40}},
           Case{"0=LWPOLYLINE 8=0 90=2 70=1 10=0 20=0 42=1 10=10 20=0 42=1", 10 * M_PI, {10, 10}},
           Case{"0=LWPOLYLINE 8=0 90=2 70=0 10=0 20=0 42=-0.41421356237309503 10=10 20=10",
                5 * M_PI,
                {10, 10}},
           Case{"0=POLYLINE 8=0 66=1 70=0 0=VERTEX 8=0 10=0 20=0 0=VERTEX 8=0 10=3 20=4 0=SEQEND 8=0 0=LINE "
                "8=0 10=3 "
                "20=4 11=6 21=0",
                10,
                {6, 4}},
           Case{"0=SPLINE 8=0 70=4 71=2 72=6 73=3 40=0 40=0 40=0 40=1 40=1 40=1 41=1 41=0.7071067811865476 "
                "41=1 10=7 "
                "20=0 10=7 20=7 10=0 20=7",
                3.5 * M_PI,
                {7, 7}},
           // Mirrored by its extrusion: from the right to the left of x = -13.
           Case{"0=ARC 8=0 10=13 20=-7 40=20 50=-90 51=90 230=-1", 20 * M_PI, {20, 40}},
       }) {
    const auto read = read_dxf(dxf_file(c.entities));
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->pattern.format(), "DXF");
    EXPECT_NEAR(length_mm(read->drawing), c.length, 3e-4 * c.length) << c.entities;
    // With half a line's width around it.
    EXPECT_LT((read->pattern.size_mm() - c.size - Vector2d(1, 1)).norm(), 5e-3) << c.entities;
    EXPECT_EQ(lines_in(read->drawing), 1u) << c.entities;
  }
}

// Of a circle with a tail on its right side, where it lands and which way it is turned.
TEST(Dxf, BlocksAreTurnedScaledMirroredNestedAndRepeated) {
  const std::string
      inner =
          "0=BLOCK 8=0 2=INNER 70=0 10=1 20=0 0=CIRCLE 8=0 10=1 20=0 40=5 0=LINE 8=0 10=6 20=0 11=16 "
          "21=0 0=ENDBLK 8=0 ",
      outer =
          "0=BLOCK 8=0 2=OUTER 70=0 10=0 20=0 0=INSERT 8=0 2=INNER 10=0 20=0 41=2 42=2 50=90 0=ENDBLK 8=0";
  // Down the page at first; then turned by -90 and mirrored in x.
  const auto read = read_dxf(
      dxf_file("0=INSERT 8=L 2=OUTER 10=100 20=50 50=-120 41=-1 0=LINE 8=L 10=100 20=50 11=100 21=51", 4,
               inner + outer));
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->drawing.elements.size(), 1u);
  EXPECT_EQ(read->drawing.elements[0].id, "OUTER");
  const Shape& tail = read->drawing.elements[0].shapes.at(1);
  const Vector2d centre = read->drawing.elements[0].shapes.at(2).curves.at(0).points.front();
  // The tail is drawn along y, at 10 to 30 mm, mirrored in x, turned by -120 degrees.
  const double a = -120 * M_PI / 180;
  const Vector2d along(-std::sin(a), std::cos(a));
  EXPECT_LT((tail.curves.at(0).points.front() - centre - 10 * along).norm(), 1e-9);
  EXPECT_LT((tail.curves.at(0).points.back() - centre - 30 * along).norm(), 1e-9);

  const auto array = read_dxf(dxf_file("0=INSERT 8=0 2=INNER 10=0 20=0 70=3 71=2 44=40 45=30", 4, inner));
  ASSERT_TRUE(array) << array.error().text();
  EXPECT_EQ(array->drawing.elements.size(), 6u);
  EXPECT_NEAR(length_mm(array->drawing), 6 * (10 * M_PI + 10), 0.1);
  EXPECT_NEAR(array->pattern.size_mm().x(), 80 + 20 + 1, 5e-3);

  const std::string endless =
      "0=BLOCK 8=0 2=A 10=0 20=0 0=INSERT 8=0 2=A 10=0 20=0 0=INSERT 8=0 2=A 10=1 20=0 0=ENDBLK 8=0";
  EXPECT_NE(
      refusal_of(dxf_file("0=INSERT 8=0 2=A 10=0 20=0", 4, endless)).find("nests blocks more than 16 deep"),
      std::string::npos);
  EXPECT_NE(refusal_of(dxf_file("0=INSERT 8=0 2=INNER 10=0 20=0 70=30000 71=30000", 4, inner))
                .find("more than 200000"),
            std::string::npos);
}

TEST(Dxf, TheUnitIsThatOfTheFileOrAskedFor) {
  const std::string line = "0=LWPOLYLINE 8=0 90=3 70=1 10=0 20=0 10=3 20=0 10=3 20=2";
  for (const auto& [units, mm] : {std::pair{1, 25.4}, {4, 1.0}, {5, 10.0}, {2, 304.8}}) {
    const auto read = read_dxf(dxf_file(line, units));
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_LT((read->pattern.size_mm() - Vector2d(3 * mm + 1, 2 * mm + 1)).norm(), 1e-9) << units;
  }
  EXPECT_EQ(read_dxf(dxf_file(line, 1))->pattern.size_from(), "3 x 2 inches, as its $INSUNITS says");
  EXPECT_EQ(refusal_of(dxf_file(line, 0)),
            "the DXF does not say its unit ($INSUNITS): it is 3 x 2 (c.dxf); say how large it is: --set "
            "pattern.width_mm=31 (31.0 x 21.0 mm, if it is drawn in cm) or --set pattern.width_mm=77.2 (77.2 "
            "x 51.8 mm, if "
            "it is drawn in inches); or set the unit in the program that made it");
  // An empty drawing of AutoCAD is in inches, and many draw in it as if it were in mm (FreeCAD 10253).
  const std::string large = "0=LWPOLYLINE 8=0 90=3 70=1 10=0 20=0 10=120 20=0 10=120 20=80";
  EXPECT_EQ(refusal_of(dxf_file(large, 1)),
            "the DXF is 3049.0 x 2033.0 mm large, in inches as its $INSUNITS says (c.dxf); say how large it "
            "is: --set "
            "pattern.width_mm=121 (121.0 x 81.0 mm, if it is drawn in mm) or --set pattern.width_mm=1201 "
            "(1201.0 x 801.0 mm, if it is drawn in cm); or set the unit in the program that made it");
  EXPECT_TRUE(read_dxf(dxf_file(large, 1), lines_of(1, 121)));
  const auto inches = read_dxf(dxf_file(line, 0), lines_of(1, 77.2));
  ASSERT_TRUE(inches) << inches.error().text();
  EXPECT_LT((inches->pattern.size_mm() - Vector2d(77.2, 51.8)).norm(), 1e-9);
}

TEST(Dxf, WidthsAreThoseOfTheFileOrAskedFor) {
  const std::string layers = "0=LAYER 2=THICK 70=0 62=7 370=70 0=LAYER 2=THIN 70=0 62=7 370=-3";
  const std::string entities =
      "0=LINE 8=THICK 10=0 20=0 11=30 21=0 0=LINE 8=THIN 370=25 10=0 20=5 11=30 21=5 0=LWPOLYLINE 8=THIN "
      "43=2.5 90=2 "
      "70=0 10=0 20=9 10=30 20=9";
  const auto read = read_dxf(dxf_file(entities, 4, "", layers), {});
  ASSERT_TRUE(read) << read.error().text();
  std::vector<double> widths;
  for (const Element& e : read->drawing.elements)
    for (const Shape& s : e.shapes) widths.push_back(s.stroke->width_mm);
  ASSERT_EQ(widths.size(), 3u);
  EXPECT_NEAR(widths[0], 0.7, 1e-9);
  EXPECT_NEAR(widths[1], 0.25, 1e-9);
  EXPECT_NEAR(widths[2], 2.5, 1e-9);
  const std::string bare = dxf_file(entities + " 0=LINE 8=THIN 10=0 20=12 11=30 21=12", 4, "", layers);
  EXPECT_EQ(refusal_of(bare, {}),
            "the DXF has 1 of 4 lines without a width (c.dxf); say how wide they are printed, for example "
            "pattern.line_mm=2");
  EXPECT_TRUE(read_dxf(bare, lines_of(1.5)));
}

// A rounded rectangle as CAD programs draw it: lines and arcs in any order and direction, which meet but for rounding.
TEST(Dxf, EndsThatMeetAreOneLine) {
  const std::string parts =
      "0=LINE 8=COIL 10=5 20=0 11=25 21=0 0=LINE 8=COIL 10=25 20=20.0004 11=5 21=20 0=ARC 8=COIL 10=25 20=5 "
      "40=5 50=270 "
      "51=0 0=LINE 8=COIL 10=0 20=5 11=0 21=15 0=ARC 8=COIL 10=5 20=5 40=5 50=180 51=270 0=LINE 8=COIL "
      "10=30.0003 20=15 "
      "11=30 21=5 0=ARC 8=COIL 10=5 20=15 40=5 50=90 51=180 0=ARC 8=COIL 10=25 20=15 40=5 50=0 51=90";
  const auto closed = read_dxf(dxf_file(parts));
  ASSERT_TRUE(closed) << closed.error().text();
  ASSERT_EQ(lines_in(closed->drawing), 1u);
  EXPECT_TRUE(closed->drawing.elements[0].shapes[0].curves[0].closed);
  EXPECT_NEAR(length_mm(closed->drawing), 2 * 20 + 2 * 10 + 10 * M_PI, 0.01);
  // A third line at a corner leaves all of them as they are there; another layer does not join.
  EXPECT_EQ(lines_in(read_dxf(dxf_file(parts + " 0=LINE 8=COIL 10=5 20=0 11=5 21=-9"))->drawing), 2u);
  EXPECT_EQ(
      lines_in(read_dxf(dxf_file("0=LINE 8=A 10=0 20=0 11=9 21=0 0=LINE 8=B 10=9 20=0 11=9 21=9"))->drawing),
      2u);
}

TEST(Dxf, SaysWhatItLeavesOut) {
  const std::string layers = "0=LAYER 2=OFF 70=0 62=-7 0=LAYER 2=FROZEN 70=1 62=7";
  const auto read = read_dxf(
      dxf_file("0=CIRCLE 8=A 10=3 20=0 40=5 0=TEXT 8=A 10=0 20=0 40=2 1=JaneDoe 0=HATCH 8=A 0=LINE 8=OFF "
               "10=0 20=0 11=99 21=0 0=LINE 8=FROZEN 10=0 20=0 11=99 21=0 0=LINE 8=A 67=1 10=0 20=0 "
               "11=99 21=0",
               4, "", layers));
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_NEAR(read->pattern.size_mm().x(), 11, 1e-3);
  ASSERT_EQ(read->pattern.warnings().size(), 1u);
  EXPECT_EQ(read->pattern.warnings()[0].code, "pattern-left-out");
  EXPECT_EQ(read->pattern.warnings()[0].text,
            "Parts of the DXF are not drawn: 1 HATCH, 1 TEXT, 2 on layers that are off, 1 on layouts.");
}

TEST(Dxf, RefusesWhatItCannotTrust) {
  const std::string good = dxf_file("0=CIRCLE 8=0 10=3 20=0 40=5");
  for (std::size_t size = 0; size < good.size(); size += 3)
    EXPECT_FALSE(Pattern::read(bytes_of(good.substr(0, size)), "c.dxf", lines_of(1), 100)) << size;
  EXPECT_EQ(refusal_of(groups("0=SECTION 2=ENTITIES") + "word\nLINE\n"),
            "the DXF has no group code on line 5 (c.dxf); export the drawing again as ASCII DXF, or as SVG");
  EXPECT_EQ(refusal_of(dxf_file("")),
            "the DXF has no lines (c.dxf); export the model with its lines, or save the drawing as SVG");
  for (const char* odd :
       {"0=CIRCLE 8=0 10=1e300 20=0 40=5", "0=LINE 8=0 10=0 20=0 30=0 11=9 21=9 31=4",
        "0=CIRCLE 8=0 10=1 40=5 210=1 230=0", "0=LWPOLYLINE 8=0 90=2 70=0 10=0 20=0 40=1 41=3 10=9 20=0",
        "0=CIRCLE 8=0 10=nan 20=0 40=inf"})
    EXPECT_NE(refusal_of(dxf_file(odd)), "") << odd;
  // Splines that cannot be drawn.
  for (const char* odd :
       {"0=SPLINE 8=0 71=3 10=0 20=0", "0=SPLINE 8=0 71=1 40=0 40=1 40=0 40=1 10=0 20=0 10=1 20=1"})
    EXPECT_NE(refusal_of(dxf_file(odd)).find("SPLINE"), std::string::npos);
  EXPECT_EQ(refusal_of("AutoCAD Binary DXF\r\n\x1a"),
            "the drawing is a binary DXF file (c.dxf); save it as ASCII DXF or as SVG");
}

TEST(Dxf, TheStoredCopyHasNoNames) {
  const std::string name = "JaneDoe";
  Bytes copy =
      bytes_of(groups("999=" + name + " 0=SECTION 2=HEADER 9=$LASTSAVEDBY 1=" + name +
                      " 9=$TDCREATE 40=2459.5 9=$INSUNITS 70=1 0=ENDSEC 0=SECTION 2=TABLES 0=TABLE 2=LAYER "
                      "5=1F 0=LAYER 2=" +
                      name + " 62=7 0=ENDTAB 0=ENDSEC 0=SECTION 2=ENTITIES 0=MTEXT 8=" + name + " 1=" + name +
                      " 3=" + name + " 0=" + name + " 8=0 0=LINE 8=" + name + " 6=" + name +
                      " 10=1 20=2 11=3 21=" + name + " 1001=" + name + " 1000=" + name +
                      " 0=ENDSEC 0=SECTION 2=OBJECTS 0=DICTIONARY 70=1984 3=" + name + " 0=ENDSEC 0=EOF") +
               name);
  ASSERT_TRUE(redact(copy, "drawing.dxf"));
  EXPECT_EQ(
      std::string(copy.begin(), copy.end()),
      groups(
          "999= 0=SECTION 2=HEADER 9=$OTHER 1= 9=$OTHER 40= 9=$INSUNITS 70=1 0=ENDSEC 0=SECTION 2=TABLES "
          "0=TABLE "
          "2=LAYER 5= 0=LAYER 2=layer-1 62=7 0=ENDTAB 0=ENDSEC 0=SECTION 2=ENTITIES 0=MTEXT 8=layer-1 1= 3= "
          "0=UNKNOWN 8=0 0=LINE 8=layer-1 6= 10=1 20=2 11=3 21= 1001= 1000= 0=ENDSEC 0=SECTION 2=OBJECTS "
          "0=UNKNOWN 70= 3= 0=ENDSEC 0=EOF"));
}

}  // namespace
}  // namespace vacuform
