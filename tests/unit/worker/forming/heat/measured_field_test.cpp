// Fields that were measured, as CSV and as gray pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "worker/forming/heat/gray_png.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/forming/heat/scattered.hpp"

namespace vacuform {
namespace {

Result<TemperatureField> measured(const std::string& text, const HeatSettings& heat = {}) {
  return read_measured_field({{text.begin(), text.end()}, "field.csv"}, {}, heat);
}

// 300 x 300 mm in two rows of three: the first row lies along the upper edge.
TEST(Measured, RowsTileTheSheetFromTheTop) {
  for (const char* text : {"150,151,152\n120,121,122\n",
                           "\xef\xbb\xbf"
                           "150;151,0;152\r\n120;121;122",
                           "# camera 3\n\n150 151\t152\n120 121 122\n", "150, 151, 152,\n120, 121, 122,\n"}) {
    const auto field = measured(text);
    ASSERT_TRUE(field) << field.error().text();
    EXPECT_NEAR(field->at({-100, 75}), 150, 1e-12) << text;
    EXPECT_NEAR(field->at({100, 75}), 152, 1e-12);
    EXPECT_NEAR(field->at({0, -75}), 121, 1e-12);
    EXPECT_NEAR(field->at({50, 0}), (151.5 + 121.5) / 2, 1e-12);
    EXPECT_NEAR(field->at({149, 149}), 152, 1e-12);
  }
  EXPECT_EQ(measured("141.5")->at({30, 20}), 141.5);
}

TEST(Measured, PointsAreInterpolatedSmoothlyAndExactly) {
  const auto field =
      measured("t_mm;s_mm;Celsius\n0;0;150\n100;-100;130,5\n100;100;131\n-100;100;129\n-100;-100;130\n");
  ASSERT_TRUE(field) << field.error().text();
  EXPECT_NEAR(field->at({0, 0}), 150, 1e-6);
  EXPECT_NEAR(field->at({-100, 100}), 130.5, 1e-6);
  EXPECT_NEAR(field->at({100, -100}), 129, 1e-6);
  const double half = field->at({50, 0});
  EXPECT_GT(half, 138);
  EXPECT_LT(half, 150);
  EXPECT_GE(field->at({150, 150}), 129);  // no wilder than what was measured
  EXPECT_LE(field->at({150, 150}), 150);
}

TEST(Measured, PointsOfAPlaneGiveThePlane) {
  std::vector<MeasuredPoint> points;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d p(140 * std::sin(7.0 * i), 140 * std::cos(5.0 * i));
    points.push_back({p, 140 + 0.05 * p.x() - 0.02 * p.y()});
  }
  const TemperatureField field = through_points(points, 300, 300);
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(20, 35), Eigen::Vector2d(-70, 60), Eigen::Vector2d(0, -90)})
    EXPECT_NEAR(field.at(p), 140 + 0.05 * p.x() - 0.02 * p.y(), 1e-6);
  // One point, points on a line, and twice the same point are no trouble.
  EXPECT_NEAR(through_points({{{10, 20}, 133}}, 300, 300).at({-50, 0}), 133, 1e-9);
  const TemperatureField line = through_points({{{-100, 0}, 120}, {{0, 0}, 130}, {{100, 0}, 140}}, 300, 300);
  EXPECT_NEAR(line.at({50, 0}), 135, 1);
  EXPECT_NEAR(line.at({50, 80}), line.at({50, -80}), 1e-6);
  const TemperatureField twice = through_points({{{0, 0}, 120}, {{0, 0}, 130}}, 300, 300);
  EXPECT_NEAR(twice.at({0, 0}), 125, 1e-9);
  // More than 400: merged, and still the plane.
  points.clear();
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector2d p((i * 37 % 301) - 150, (i * 101 % 299) - 149);
    points.push_back({p, 140 + 0.05 * p.x()});
  }
  EXPECT_NEAR(through_points(points, 300, 300).at({80, 20}), 144, 0.05);
}

TEST(Measured, NamesTheLineOfAnError) {
  struct Case {
    const char *text, *where, *says;
  };
  for (const Case& c :
       {Case{"", "field.csv", "no temperature"}, Case{"\n# only words\n", "field.csv", "no temperature"},
        Case{"140,141\n140\n", "field.csv, line 2", "a row of 1"},
        Case{"140,x\n", "field.csv, line 1", "not a number: \"x\""},
        Case{"140,nan\n", "field.csv, line 1", "not a number"},
        Case{"140,,141", "field.csv, line 1", "not a number"},
        Case{"413.15,414\n1000,410", "field.csv, line 2", "1000 C"},
        Case{"s,t\n1,2", "field.csv, line 1", "columns s, t and celsius"},
        Case{"s,t,celsius\n", "field.csv, line 1", "no point"},
        Case{"s,t,celsius\n1,2,140\n1,2", "field.csv, line 3", "not a number"},
        Case{"s,t,celsius\n900,2,140", "field.csv, line 2", "off the sheet"},
        Case{"s,t,celsius\n1,,140", "field.csv, line 2", "two numbers"},
        Case{"\x01\x02\xff\xfe", "field.csv, line 1", "not a number: \"??"}}) {
    const auto field = measured(c.text);
    ASSERT_FALSE(field) << c.text;
    EXPECT_EQ(field.error().code, Code::corrupt_file) << c.text;
    EXPECT_EQ(field.error().where, c.where) << c.text;
    EXPECT_NE(field.error().what.find(c.says), std::string::npos) << field.error().text();
  }
}

// A gray PNG of 3 x 2 pixels of 8 bits: 0, 51, 102 over 153, 204, 255. Written once with Python's zlib.
constexpr std::uint8_t gray_3x2[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
    0x52, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x02, 0x08, 0x00, 0x00, 0x00, 0x00, 0xb8,
    0x1f, 0x39, 0xc6, 0x00, 0x00, 0x00, 0x10, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0x60,
    0x30, 0x4e, 0x63, 0x98, 0x79, 0xe6, 0x3f, 0x00, 0x07, 0x9a, 0x02, 0xfe, 0x07, 0xb3, 0x50,
    0x57, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

TEST(Measured, GrayPicturesNeedAScale) {
  HeatSettings heat;
  EXPECT_EQ(
      read_measured_field({{std::begin(gray_3x2), std::end(gray_3x2)}, "camera.png"}, {}, heat).error().where,
      "heat.black_c");
  heat.black_c = 100;
  heat.white_c = 200;
  const auto field =
      read_measured_field({{std::begin(gray_3x2), std::end(gray_3x2)}, "camera.png"}, {}, heat);
  ASSERT_TRUE(field) << field.error().text();
  EXPECT_NEAR(field->at({-100, 75}), 100, 1e-9);
  EXPECT_NEAR(field->at({0, 75}), 120, 1e-9);
  EXPECT_NEAR(field->at({100, -75}), 200, 1e-9);
  // Cut anywhere, or with any byte changed, it is refused or read, and never more than that.
  for (std::size_t n = 0; n < sizeof gray_3x2; ++n)
    EXPECT_FALSE(read_gray_png(std::span(gray_3x2).first(n), "camera.png")) << n;
  for (std::size_t i = 8; i < sizeof gray_3x2; ++i) {
    auto bytes = std::to_array(gray_3x2);
    bytes[i] ^= 0x55;
    const auto picture = read_gray_png(bytes, "camera.png");
    EXPECT_TRUE(!picture || picture->pixels.size() == 6) << i;
  }
  auto colour = std::to_array(gray_3x2);
  colour[25] = 2;
  EXPECT_EQ(read_gray_png(colour, "camera.png").error().code, Code::unsupported_format);
  auto huge = std::to_array(gray_3x2);
  huge[17] = 1;  // 65,539 pixels wide
  huge[22] = 1;
  EXPECT_EQ(read_gray_png(huge, "camera.png").error().code, Code::too_large);
}

}  // namespace
}  // namespace vacuform
