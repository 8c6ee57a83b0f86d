#include "api/job_text.hpp"

#include <gtest/gtest.h>

#include "api/base/utf8.hpp"

namespace vacuform {
namespace {

std::string many(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

TEST(Utf8, IsReadAndWrittenStrictly) {
  for (const char* text : {"", "a~", "ä ß", "北京", "𝄞 \xf4\x8f\xbf\xbf"})
    EXPECT_EQ(utf8(code_points(text).value()), text);
  EXPECT_EQ(code_points("€𝄞").value(), (std::u32string{0x20ac, 0x1d11e}));
  for (const char* bytes : {"\x80", "\xc0\xaf", "\xc3", "\xe2\x82", "\xe0\x80\x80", "\xed\xa0\x80",
                            "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"})
    EXPECT_FALSE(code_points(bytes)) << bytes;
}

TEST(Utf8, IsFoldedWithItsUmlauts) {
  EXPECT_EQ(folded("KÖLN Äpfel ÉŽ Ω Д"), folded("köln äPFEL éž ω д"));
  EXPECT_NE(folded("Koln"), folded("Köln"));
  EXPECT_TRUE(folded("\xff").empty());
}

TEST(Reference, IsOneLineWithoutBlanksAroundIt) {
  EXPECT_EQ(clean_reference("  CASE-12/ä 7 \r\n").value(), "CASE-12/ä 7");
  EXPECT_EQ(clean_reference("\xc2\xa0 \xe3\x80\x80").value(), "");
  EXPECT_EQ(clean_reference(many("𝄞", 64)).value(), many("𝄞", 64));
  // 65 characters; a control character, a line break, and what nobody sees.
  for (const std::string& wrong :
       {many("ä", 65), std::string("a\0b", 3), std::string("a\nb"), std::string("a\tb"),
        std::string("a\xc2\x85"
                    "b"),
        std::string("a\xe2\x80\x8b"
                    "b"),
        std::string("a\xe2\x80\xae"
                    "b"),
        std::string("a\xe2\x80\xa8"
                    "b"),
        std::string("a\xee\x80\x80"
                    "b"),
        std::string("\xef\xbf\xbf"), std::string("\xff")}) {
    const auto refused = clean_reference(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, Code::bad_usage);
    EXPECT_EQ(refused.error().where, "reference");
    EXPECT_EQ(refused.error().text().find(wrong), std::string::npos);  // it may hold anything
  }
}

TEST(Note, KeepsItsLines) {
  EXPECT_EQ(clean_note("\n first\r\nsecond\rthird\n\n").value(), "first\nsecond\nthird");
  EXPECT_EQ(clean_note(many("ä", 500)).value(), many("ä", 500));
  for (const std::string& wrong :
       {many("ä", 501), std::string("a\tb"), std::string("a\x7f"), std::string("\xff")}) {
    const auto refused = clean_note(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().where, "note");
  }
}

}  // namespace
}  // namespace vacuform
