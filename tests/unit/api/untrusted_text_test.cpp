// Texts of others: what acts in a terminal is written out, and JSON is bounded before it is parsed.
#include <gtest/gtest.h>

#include "api/base/error.hpp"
#include "api/base/json_text.hpp"
#include "api/base/utf8.hpp"

namespace vacuform {
namespace {

TEST(Printable, LeavesTextAsItIs) {
  for (const char* text : {"", "a head", "Größe 3 × 4 µm", "頭", "\xF0\x9F\xA7\xA0", "a\\b"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WritesOutWhatActs) {
  EXPECT_EQ(printable("\x1b]0;title\x07"), "\\x1b]0;title\\x07");
  EXPECT_EQ(printable("a\nb\tc\rd\x7f"), "a\\x0ab\\x09c\\x0dd\\x7f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\x9b31m");                                                  // the one-character CSI
  EXPECT_EQ(printable("scan\xE2\x80\xAElts.exe"), "scan\\u202elts.exe");  // right to left
  EXPECT_EQ(printable("\xE2\x81\xA6x\xE2\x80\xA8y\xEF\xBB\xBFz\xD8\x9C"), "\\u2066x\\u2028y\\ufeffz\\u061c");
  EXPECT_EQ(printable("\xff\xc3(\xe2\x80"), "\\xff\\xc3(\\xe2\\x80");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
}

TEST(Printable, IsHowAnErrorIsShown) {
  const Error error{Code::corrupt_file, "\"\x1b[2J\" is no keyword", "a\xE2\x80\xAE.stl", "export\nagain"};
  EXPECT_EQ(error.text(), "\"\\x1b[2J\" is no keyword (a\\u202e.stl); export again");
}

TEST(JsonWithin, CountsLevelsAndValues) {
  const JsonLimits limits{.levels = 3, .values = 8};
  for (const char* text : {"1", "[[[1]]]", "{\"a\":{\"b\":[1,2,3]}}", "\"[[[[[[\"", "\"\\\"[[[[[\"",
                           "[1,2,3,4,5,6]", "]]]]", ""})
    EXPECT_TRUE(within(text, limits)) << text;
  for (const char* text :
       {"[[[[", "[[[[]]]]", "{\"a\":{\"b\":{\"c\":{}}}}", "[1,2,3,4,5,6,7,8]", "[],[],[],[],[]"})
    EXPECT_FALSE(within(text, limits)) << text;
  EXPECT_FALSE(within(std::string(4 << 20, '['), {}));
  std::string many = "[1";
  for (int i = 0; i < 300'000; ++i) many += ",1";
  EXPECT_FALSE(within(many + "]", {}));
}

}  // namespace
}  // namespace vacuform
