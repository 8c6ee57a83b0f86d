// A zip of drawings is written as one SVG with a group for each layer, or refused.
#include <gtest/gtest.h>

#include "api/redaction/redaction.hpp"
#include "tests/unit/fixtures/zip_files.hpp"

namespace vacuform::redaction_layers_test {
namespace {

using zip_files::Entry;
using zip_files::zip;

Result<std::string> written(const std::vector<Entry>& entries) {
  const std::string bytes = zip(entries);
  std::vector<std::uint8_t> whole(bytes.begin(), bytes.end());
  VACUFORM_CHECK(redact(whole, "a.zip"));
  return std::string(whole.begin(), whole.end());
}

std::string svg(const std::string& body,
                const std::string& root = R"(width="80mm" height="60mm" viewBox="0 0 80 60")") {
  return R"(<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" )" +
         root + ">" + body + "</svg>";
}
std::string with_xlink(const std::string& body) {
  return svg(body,
             R"(xmlns:xlink="http://www.w3.org/1999/xlink" width="80mm" height="60mm" viewBox="0 0 80 60")");
}

// The drawing without its first tag.
std::string body_of(const std::string& text) { return text.substr(text.find('>') + 1); }

TEST(RedactionOfLayers, WritesOneDrawingWithAGroupForEachFile) {
  const auto out = written(
      {{"head of JaneDoe/", "", false},
       {"head of JaneDoe/JaneDoe-F_Cu.svg",
        svg("<path id=\"a\" d=\"M0 0\"/>", R"(width="80mm" height="60mm" viewBox="0 0 80 60" fill="none")")},
       {"__MACOSX/._x-dielectric.svg", "x"},
       {"readme.txt", "JaneDoe"},
       {"JaneDoe_Dielectric Reverse.SVG", svg("<g/>")}});
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(out->find("JaneDoe"), std::string::npos) << *out;
  EXPECT_EQ(
      body_of(*out),
      R"(<g inkscape:groupmode="layer" inkscape:label="f_cu" fill="none"><path id="a" d="M0 0"></path></g>)"
      R"(<g inkscape:groupmode="layer" inkscape:label="dielectric reverse"><g></g></g></svg>)");
  EXPECT_NE(out->find(R"(width="80mm" height="60mm" viewBox="0 0 80 60">)"), std::string::npos) << *out;
  std::vector<std::uint8_t> again(out->begin(), out->end());
  ASSERT_TRUE(redact(again, "a.zip"));
  EXPECT_EQ(std::string(again.begin(), again.end()), *out);
}

TEST(RedactionOfLayers, KeepsIdsAndClassesOfEachFileApart) {
  const std::string sheet = "<style>.st0, g#a &gt; .st1{stroke:url(#b);fill:#b00} /* n */ .st2{}</style>";
  const std::string shapes =
      R"svg(<g id="a" class="st0  st3"/><use xlink:href="#a" style="clip-path:url('#b')"/>)svg";
  const auto out = written({{"conductor.svg", with_xlink(sheet + shapes)},
                            {"bridges.svg", with_xlink(sheet + shapes + "<g id=\"st0_2\"/>")}});
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_NE(out->find("<style>.st0, g#a &gt; .st1{stroke:url(#b);fill:#b00}  .st2{}</style>"),
            std::string::npos)
      << *out;
  // A class that only a sheet names may be one of the other file.
  EXPECT_NE(out->find("<style>.st0_3, g#a_3 &gt; .st1_3{stroke:url(#b);fill:#b00}  .st2_3{}"),
            std::string::npos)
      << *out;
  EXPECT_NE(
      out->find(
          R"svg(<g id="a_3" class="st0_3  st3_3"></g><use xlink:href="#a_3" style="clip-path:url('#b')">)svg"),
      std::string::npos)
      << *out;
}

// As plotting programs write them.
TEST(RedactionOfLayers, KeepsARuleThatAllFilesHave) {
  const std::string drawing = svg("<style>*{stroke-linecap: butt}</style><g/>");
  const auto out = written({{"conductor.svg", drawing}, {"bridges.svg", drawing}});
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_NE(out->find("label=\"bridges\"><style>*{stroke-linecap: butt}</style>"), std::string::npos) << *out;
  EXPECT_FALSE(
      written({{"conductor.svg", drawing}, {"bridges.svg", svg("<style>*{stroke-linecap: round}</style>")}}));
}

TEST(RedactionOfLayers, UnpacksPackedDrawings) {
  const std::string plain = svg("<g/>");
  // gzip: the head, the packed bytes, their checksum and length.
  std::string packed("\x1f\x8b\x08\0\0\0\0\0\0\3", 10);
  packed += zip_files::deflated(plain);
  zip_files::put(packed,
                 crc32(0, reinterpret_cast<const Bytef*>(plain.data()), static_cast<uInt>(plain.size())), 4);
  zip_files::put(packed, plain.size(), 4);
  const auto out = written({{"silver.svgz", packed, false}, {"insulator.svg", plain}});
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_NE(out->find("inkscape:label=\"silver\""), std::string::npos);
}

struct Refused {
  std::string name;
  std::vector<Entry> entries;
  std::string what;
};
class LayersRefusal : public testing::TestWithParam<Refused> {};
TEST_P(LayersRefusal, NamesTheFile) {
  const auto out = written(GetParam().entries);
  ASSERT_FALSE(out);
  EXPECT_NE(out.error().text().find(GetParam().what), std::string::npos) << out.error().text();
  EXPECT_EQ(out.error().where, "the zip, " + GetParam().entries.back().name);
  EXPECT_FALSE(out.error().fix.empty());
}
INSTANTIATE_TEST_SUITE_P(
    OfAZip, LayersRefusal,
    testing::Values(
        Refused{"AnotherPage",
                {{"conductor.svg", svg("")},
                 {"bridges.svg", svg("", R"(width="90mm" height="60mm" viewBox="0 0 90 60")")}},
                "width 80mm, height 60mm, viewBox 0 0 80 60 in conductor.svg, width 90mm"},
        Refused{"PixelsOfAnotherProgram",
                {{"conductor.svg",
                  svg("", R"(width="90" height="60" inkscape:version="0.91" viewBox="0 0 90 60")")},
                 {"bridges.svg",
                  svg("", R"(width="90" height="60" inkscape:version="1.2" viewBox="0 0 90 60")")}},
                "by 1.2 in this one"},
        Refused{"NoLayer", {{"conductor.svg", svg("")}, {"coils.svg", svg("")}}, "says no layer"},
        Refused{"PartOfAWord", {{"conductor.svg", svg("")}, {"nonconductor.svg", svg("")}}, "says no layer"},
        Refused{"Picture", {{"conductor.svg", svg("")}, {"picture.png", "x"}}, "is no SVG"},
        Refused{"DamagedFile", {{"conductor.svg", svg("")}, {"bridges.svg", "<svg"}}, "cannot be read"},
        Refused{"StyleOfElements",
                {{"conductor.svg", svg("")}, {"bridges.svg", svg("<style>.a{} path{fill:none}</style>")}},
                "style the other drawings"},
        Refused{"StyleOfAMedium",
                {{"conductor.svg", svg("")}, {"bridges.svg", svg("<style>@media print{.a{}}</style>")}},
                "style the other drawings"}),
    [](const auto& all) { return all.param.name; });

TEST(RedactionOfLayers, LimitsAllOfThemTogether) {
  std::string text(std::size_t{17} << 20, ' ');
  for (std::size_t i = 0; i < text.size(); i += 3)
    text[i] = static_cast<char>('a' + i * 7919 % 23);  // is not packed well
  const auto out = written({{"conductor.svg", svg(text), false}, {"bridges.svg", svg(text), false}});
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, Code::too_large);
}

}  // namespace
}  // namespace vacuform::redaction_layers_test
