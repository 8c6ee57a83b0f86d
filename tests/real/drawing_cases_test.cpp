// Drawings of the kinds that programs write: of which size they are, and that lines stay lines.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "api/redaction/redaction.hpp"
#include "tests/real/real_scans.hpp"
#include "worker/pattern/drawing.hpp"
#include "worker/pattern/ink_checks.hpp"

namespace vacuform::drawing_cases_test {
namespace {

using Eigen::Vector2d;

struct DrawnCase {
  Result<Pattern> pattern;
  std::optional<Drawing> lines;
  std::vector<Warning> warnings;
};
std::optional<DrawnCase> drawn_case(const std::string& name) {
  std::ifstream in(std::string(VACUFORM_SHARED_DATA) + "/cases/" + name, std::ios::binary);
  if (!in) return std::nullopt;
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  EXPECT_TRUE(redact(bytes, name));
  DrawnCase out{Pattern::read(bytes, name, {}, 300), {}, {}};
  if (!out.pattern) return out;
  out.lines = read_drawing(*out.pattern, out.warnings);
  for (Warning& warning : check_ink(*out.pattern, out.lines, 1, 300))
    out.warnings.push_back(std::move(warning));
  return out;
}

TEST(DrawingCases, AreAsLargeAsTheirProgramsMeantThem) {
  if (!drawn_case("ai_px.svg") && !real::required()) GTEST_SKIP() << real::missing("");
  const std::pair<const char*, Vector2d> sizes[] = {
      {"ai_px.svg", {120, 80}},     {"ink091_px.svg", {120, 80}},  {"w_upper.svg", {120, 80}},
      {"kicad.svg", {150, 150}},    {"ai_native.svg", {150, 150}}, {"utf16.svg", {150, 150}},
      {"hairline.svg", {150, 150}}, {"dark.svg", {150, 150}}};
  for (const auto& [name, size] : sizes) {
    const auto drawn = drawn_case(name);
    ASSERT_TRUE(drawn) << name;
    ASSERT_TRUE(drawn->pattern) << drawn->pattern.error().text();
    EXPECT_LT((drawn->pattern->size_mm() - size).norm(), 0.002) << name;
    EXPECT_TRUE(drawn->lines) << name;
    const std::string expected = name == std::string("hairline.svg") ? "lines-thin"
                                 : name == std::string("dark.svg")   ? "pattern-dark"
                                                                     : "";
    EXPECT_EQ(drawn->warnings.size(), expected.empty() ? 0u : 1u) << name;
    if (!expected.empty()) {
      EXPECT_EQ(drawn->warnings.at(0).code, expected);
    }
    if (expected == "lines-thin") {
      EXPECT_EQ(drawn->warnings.at(0).place, "c0, c1, c2, c3, c4, c5, c6");
    }
  }
}

TEST(DrawingCases, AreAskedAboutWhereNobodyKnows) {
  if (!drawn_case("w_unitless.svg") && !real::required()) GTEST_SKIP() << real::missing("");
  for (const auto& [name, proposals] :
       {std::pair<const char*, std::size_t>{"w_unitless.svg", 4}, {"jfif72_exif100.jpg", 2}}) {
    const auto drawn = drawn_case(name);
    ASSERT_TRUE(drawn) << name;
    ASSERT_FALSE(drawn->pattern) << name;
    EXPECT_EQ(drawn->pattern.error().code, Code::unusable_pattern);
    EXPECT_EQ(drawn->pattern.error().proposals.size(), proposals) << drawn->pattern.error().text();
  }
}

}  // namespace
}  // namespace vacuform::drawing_cases_test
