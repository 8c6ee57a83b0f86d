// A zip of a model is written again without names, or refused.
#include <gtest/gtest.h>

#include "api/redaction/redaction.hpp"
#include "tests/unit/fixtures/zip_files.hpp"

namespace vacuform {
namespace {

using zip_files::Entry;
using zip_files::zip;

const std::string jane = "JaneDoe1984";

std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string typed = type + data;
  const auto crc = crc32(0, reinterpret_cast<const Bytef*>(typed.data()), static_cast<uInt>(typed.size()));
  std::string out;
  for (const std::uint64_t number : {std::uint64_t{data.size()}, std::uint64_t{crc}})
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(number >> shift & 0xff);
  return out.substr(0, 4) + typed + out.substr(4);
}
std::string png() {
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", std::string(13, '\1')) +
         png_chunk("tEXt", "Author\1" + jane) + png_chunk("IDAT", "pixels") + png_chunk("IEND", "");
}

Result<std::string> written(const std::string& bytes) {
  std::vector<std::uint8_t> whole(bytes.begin(), bytes.end());
  VACUFORM_CHECK(redact(whole, "a.zip"));
  return std::string(whole.begin(), whole.end());
}

std::vector<Entry> model() {
  const std::string obj = "# by " + jane + "\r\nmtllib " + jane + ".mtl\r\no " + jane + "\r\nv 0 0 0 # " +
                          jane + "\r\nv 1 0 0\r\nv 0 1 0\r\nvt 0 0\r\nusemtl skin of " + jane +
                          "\r\nf 1/1 \\\r\n2/1 3/1\r\n";
  const std::string mtl = "# " + jane + "\nnewmtl hair\nKd 1 0 0\nnewmtl skin of " + jane +
                          "\nKd 0.5 0.5 0.5\nNs 10\nmap_Ks " + jane +
                          ".tga\nmap_Kd -s 2 2 -o 0.5 0 0 -mm 0 1 " + "textures\\" + jane + " face.PNG\n";
  return {{"scan of " + jane + "/", "", false},
          {"__MACOSX/._" + jane + ".obj", jane},
          {"scan of " + jane + "/" + jane + ".obj", obj},
          {"scan of " + jane + "/license of " + jane + ".txt", jane},
          {"scan of " + jane + "/" + jane + ".mtl", mtl, true, true},
          {"scan of " + jane + "/textures/" + jane + " face.png", png(), false}};
}

std::string with_fine_texts() {
  return "\nmtllib model.mtl\n\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m1\nf 1/1 \\\n2/1 3/1\n";
}

TEST(RedactionOfZip, KeepsTheModelAndNoName) {
  const auto out = written(zip(model()));
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(out->find(jane), std::string::npos);
  EXPECT_NE(out->find(with_fine_texts()), std::string::npos) << *out;
  EXPECT_NE(
      out->find("\nnewmtl m2\nKd 1 0 0\nnewmtl m1\nKd 0.5 0.5 0.5\n\n\nmap_Kd -s 2 2 -o 0.5 0 0 texture-1\n"),
      std::string::npos)
      << *out;
  for (const char* entry : {"model.obj", "model.mtl", "texture-1"})
    EXPECT_NE(out->find(entry), std::string::npos);
  EXPECT_NE(out->find("pixels"), std::string::npos);
}

TEST(RedactionOfZip, KeepsTheAxesOfThePatientAndTheCaseOfKd) {
  const auto out = written(zip({{"a.obj", "# " + jane + " SPACE=LPS\nmtllib a.mtl\nv 0 0 0\nusemtl a\n"},
                                {"a.mtl", "newmtl a\nkd 1 0 0\n"}}));
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_NE(out->find("# SPACE=LPS\nmtllib model.mtl\nv 0 0 0\nusemtl m1\n"), std::string::npos) << *out;
  EXPECT_NE(out->find("newmtl m1\nkd 1 0 0\n"), std::string::npos) << *out;
  EXPECT_EQ(out->find(jane), std::string::npos);
}

TEST(RedactionOfZip, ChangesNothingTheSecondTime) {
  const auto out = written(zip(model()));
  ASSERT_TRUE(out) << out.error().text();
  const auto again = written(*out);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(*again, *out);
}

TEST(RedactionOfZip, KeepsThePointsOfAPlyAndTheNumberOfItsTexture) {
  const std::string header = "ply\nformat binary_little_endian 1.0\ncomment TextureFile " + jane +
                             ".jpg\ncomment " + jane +
                             "\nelement vertex 1\nproperty short x\nproperty char " + jane + "\nend_header\n";
  const auto out = written(zip({{jane + ".jpg", std::string("\xff\xd8\xff\xd9", 4) + jane},
                                {jane + ".ply", header + "\r\n\x01" + jane}}));
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(out->find(jane), std::string::npos);
  EXPECT_NE(
      out->find(
          "comment TextureFile texture-1\ncomment\nelement vertex 1\nproperty short x\nproperty char other\n"
          "end_header\n\r\n\x01"),
      std::string::npos);
}

TEST(RedactionOfZip, WritesAFileOfSeveralBlocks) {
  std::string obj;
  for (int i = 0; obj.size() < 200'000; ++i) obj += "v " + std::to_string(i) + " 0 0\n";
  const auto out = written(zip({{"a.obj", obj}}));
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_NEAR(static_cast<double>(out->size()), static_cast<double>(obj.size()), 200);
  const auto again = written(*out);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(*again, *out);
}

TEST(RedactionOfZip, LeavesOutWhatTheArchiveDoesNotList) {
  const std::string obj = "v 1 2 3\n";
  const auto out =
      written(zip({{"a.obj", obj}, {"b.png", png(), true, false, 0100644, 0, 0xffff, -1, false}}));
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_EQ(*out, written(zip({{"a.obj", obj}})).value());
}

struct Refused {
  const char* name;
  std::vector<Entry> entries;
  Code code;
  const char* what;
};
void PrintTo(const Refused& lie, std::ostream* out) { *out << lie.name; }

void expect_refused(const std::vector<Entry>& entries, Code code, const std::string& what) {
  const auto out = written(zip(entries));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, code);
  EXPECT_NE(out.error().text().find(what), std::string::npos) << out.error().text();
  EXPECT_FALSE(out.error().fix.empty());
}

class ZipRefusal : public testing::TestWithParam<Refused> {};
TEST_P(ZipRefusal, NamesTheFault) {
  const Refused& refused = GetParam();
  expect_refused(refused.entries, refused.code, refused.what);
}

const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
std::vector<Entry> with_map(const std::string& image, const std::vector<Entry>& more = {}) {
  std::vector<Entry> all{{"a.obj", triangle}, {"a.mtl", "newmtl a\nmap_Kd " + image + "\n"}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

INSTANTIATE_TEST_SUITE_P(
    OfAZip, ZipRefusal,
    testing::Values(
        Refused{"OtherMaterials",
                {{"a.obj", triangle + "usemtl Mat\nf 1 3 2\n"}, {"a.mtl", "newmtl Textured\nKd 1 0 0\n"}},
                Code::unusable_scan,
                "it defines Textured, and the model uses Mat"},
        Refused{"MissingImage", with_map("skin.png"), Code::unusable_scan, "lacks the image skin.png"},
        Refused{"AbsolutePath", with_map("/etc/passwd.png"), Code::corrupt_file,
                "a path is absolute: /etc/passwd.png"},
        Refused{"PathOfAnotherSystem", with_map("C:\\skin.png"), Code::corrupt_file,
                "a path is absolute: C:/skin.png"},
        Refused{"ParentPath", with_map("../skin.png"), Code::corrupt_file, "parent folder: ../skin.png"},
        Refused{"ParentEntry", {{"../a.obj", triangle}}, Code::corrupt_file, "parent folder: ../a.obj"},
        Refused{"AbsoluteEntry", {{"/a.obj", triangle}}, Code::corrupt_file, "a path is absolute: /a.obj"},
        Refused{"WebP", with_map("skin.webp", {{"skin.webp", std::string("RIFF\x10\0\0\0WEBPVP8 ", 16)}}),
                Code::unsupported_format, "skin.webp is a WebP image"},
        Refused{"WebPCalledPng",
                with_map("skin.png", {{"skin.png", std::string("RIFF\x10\0\0\0WEBPVP8 ", 16)}}),
                Code::unsupported_format, "skin.png is a WebP image"},
        Refused{"Ktx2", with_map("skin.ktx2", {{"skin.ktx2", "\xabKTX 20\xbb\r\n\x1a\n"}}),
                Code::unsupported_format, "skin.ktx2 is a KTX image"},
        Refused{"Tga", with_map("skin.tga", {{"skin.tga", std::string(40, '\0')}}), Code::unsupported_format,
                "skin.tga is a TGA image"},
        Refused{"TwoModels",
                {{"a.obj", triangle}, {"b.obj", triangle}},
                Code::unusable_scan,
                "more than one model"},
        Refused{"NoModel", {{"notes.txt", "nothing"}}, Code::unusable_scan, "holds no model"},
        Refused{"TwoImagesOfOneName",
                {{"a.obj", triangle}, {"x/s.png", png()}, {"y/S.png", png()}},
                Code::corrupt_file,
                "two images of the same name"},
        Refused{"Encrypted",
                {{"a.obj", triangle, true, false, 0100644, 1}},
                Code::unsupported_format,
                "is encrypted"},
        Refused{"AnotherMethod",
                {{"a.obj", triangle, true, false, 0100644, 0, 14}},
                Code::unsupported_format,
                "packed by method 14"},
        Refused{"Link", {{"a.obj", triangle, true, false, 0120777}}, Code::corrupt_file, "holds a link"},
        Refused{"LyingSize",
                {{"a.obj", triangle, true, false, 0100644, 0, 0xffff, 5}},
                Code::corrupt_file,
                "another size or checksum"},
        Refused{"LyingSizeAfterTheData",
                {{"a.obj", triangle, true, true, 0100644, 0, 0xffff, 5}},
                Code::corrupt_file,
                "another size or checksum"},
        Refused{"ManyEntries", std::vector<Entry>(1001, Entry{"a.txt", "x", false}), Code::too_large,
                "more than 1000 entries"}),
    [](const auto& all) { return std::string(all.param.name); });

// These are large, so they are not among the values above: every start of this program makes those.
TEST(RedactionOfZip, RefusesABomb) {
  const std::string bomb(std::size_t{64} << 20, '\n');
  expect_refused({{"a.obj", bomb}}, Code::too_large, "more than 200 times");
  expect_refused({{"notes.txt", bomb}, {"a.obj", triangle}}, Code::too_large, "more than 200 times");
}

TEST(RedactionOfZip, RefusesALineWithoutEnd) {
  expect_refused({{"a.obj", std::string(std::size_t{3} << 20, 'x'), false}}, Code::corrupt_file,
                 "longer than a mebibyte");
}

TEST(RedactionOfZip, RefusesATruncatedArchive) {
  const std::string whole = zip(model());
  for (std::size_t bytes = 4; bytes + 30 < whole.size(); bytes += 97) {
    EXPECT_FALSE(written(whole.substr(0, bytes))) << bytes;
  }
}

}  // namespace
}  // namespace vacuform
