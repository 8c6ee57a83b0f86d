// Names in files are blanked and nothing else is: the same bytes out, but for those that may name someone.
#include "api/names.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

const std::string name = "JaneDoe1984";

// The filter's output for every way in which the bytes may arrive must be the same; a second time changes nothing.
std::string blanked(const std::string& bytes, const std::string& extension) {
  const auto in_steps = [&](const std::string& all, std::size_t step) {
    NameFilter filter(extension);
    std::string out;
    for (std::size_t at = 0; at < all.size(); at += step)
      out += filter.pass(std::string_view(all).substr(at, step));
    return out + filter.finish();
  };
  const std::string out = in_steps(bytes, bytes.size() + 1);
  for (const std::size_t step : {1, 7, 84, 85}) EXPECT_EQ(in_steps(bytes, step), out) << step;
  EXPECT_EQ(in_steps(out, 64), out);
  EXPECT_EQ(out.size(), bytes.size());
  EXPECT_EQ(out.find(name), std::string::npos);
  std::vector<std::uint8_t> whole(bytes.begin(), bytes.end());
  blank_names(whole, "Scan of " + name + "." + extension);
  EXPECT_EQ(std::string(whole.begin(), whole.end()), out);
  return out;
}

std::string padded(std::string text, std::size_t size) { return text.append(size - text.size(), ' '); }
std::string blanks(std::size_t n) { return std::string(n, ' '); }

TEST(Names, OfBinaryStl) {
  const std::string body = std::string("\x01\0\0\0", 4) + std::string(50, '\x07');
  for (const std::string& head : {padded(name, 80), padded("solid " + name, 80)})
    for (const char* extension : {"stl", ""}) EXPECT_EQ(blanked(head + body, extension), blanks(80) + body);
}

TEST(Names, OfTextStl) {
  const std::string facets =
      "facet normal 0 0 1\n outer loop\n  vertex 1 2 3\n  vertex 1e-3 2 3\n  vertex 3 3 3\n "
      "endloop\nendfacet\n";
  EXPECT_EQ(blanked("solid " + name + " by\n" + name + "\r\n" + facets + "endsolid " + name, "stl"),
            "solid " + blanks(name.size() + 3) + "\n" + blanks(name.size()) + "\r\n" + facets + "endsolid " +
                blanks(name.size()));
  EXPECT_EQ(blanked("solid" + name + "\n" + facets, "stl"), "solid" + blanks(name.size()) + "\n" + facets);
  // What a reader refuses must stay for it to refuse.
  EXPECT_EQ(blanked("solid x\n" + facets + "nonsense 7\n", "stl"), "solid  \n" + facets + "nonsense 7\n");
}

TEST(Names, OfObj) {
  const std::string kept = "v 1 2 3\nvn 0 0 1\nvt 0.5 0.25\nf 1/1/1 2/2/2 \\\n 3/3/3\ns off\n";
  EXPECT_EQ(blanked("# " + name + "\nmtllib " + name + ".mtl\no " + name + "\n" + kept + "v 1 2 3 # " + name +
                        "\n" + name + " 1\n",
                    "obj"),
            blanks(2 + name.size()) + "\nmtllib " + blanks(4 + name.size()) + "\no " + blanks(name.size()) +
                "\n" + kept + "v 1 2 3 " + blanks(2 + name.size()) + "\n" + blanks(name.size() + 2) + "\n");
  EXPECT_EQ(blanked("# \\\n" + name + "\nv 1 2 3\n", "obj"),
            blanks(3) + "\n" + blanks(name.size()) + "\nv 1 2 3\n");
  EXPECT_EQ(blanked("g " + name, ""), "g " + blanks(name.size()));
}

TEST(Names, OfPlyAndOff) {
  const std::string body =
      "end_header\n\x01\x02"
      "comment stays\n";
  EXPECT_EQ(blanked("ply\nformat binary_little_endian 1.0\ncomment by " + name + "\nobj_info " + name +
                        "\nelement vertex 1\n" + body,
                    "ply"),
            "ply\nformat binary_little_endian 1.0\ncomment " + blanks(3 + name.size()) + "\nobj_info " +
                blanks(name.size()) + "\nelement vertex 1\n" + body);
  EXPECT_EQ(
      blanked("OFF # " + name + "\n3 1 0\n0 0 0.123456789012345 #" + name + "\n", "off"),
      "OFF " + blanks(2 + name.size()) + "\n3 1 0\n0 0 0.123456789012345 " + blanks(1 + name.size()) + "\n");
}

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xFF);
  return bytes;
}
std::string chunk(const std::string& type, const std::string& data, std::uint32_t crc) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc);
}

TEST(Names, OfPng) {
  const std::string signature = "\x89PNG\r\n\x1a\n", end = chunk("IEND", "", 0xAE426082);
  const std::string picture =
      chunk("IHDR", std::string(13, '\x01'), 1) + chunk("IDAT", "tEXt" + std::string(60, 'x'), 2);
  const std::string text = "Author" + std::string(1, '\0') + name;
  for (const char* type : {"tEXt", "zTXt", "iTXt", "eXIf"}) {
    // CRC-32 of "vfNo" and 18 zeros, from zlib.
    const std::string empty = chunk("vfNo", std::string(text.size(), '\0'), 0xA0F99A49);
    EXPECT_EQ(blanked(signature + chunk(type, text, 3) + picture + end + name, "png"),
              signature + empty + picture + end + std::string(name.size(), '\0'))
        << type;
  }
}

std::string segment(char marker, const std::string& data) {
  const std::size_t size = data.size() + 2;
  return std::string("\xFF") + marker + static_cast<char>(size >> 8) + static_cast<char>(size & 0xFF) + data;
}
// Big-endian Exif with one text and an orientation, 0x0112, as cameras write it.
std::string exif(char orientation) {
  return std::string("Exif\0\0MM\0*\0\0\0\x08\0\x02", 16) +
         std::string("\x01\x0E\0\x02\0\0\0\x0B\0\0\0\x26", 12) +
         std::string("\x01\x12\0\x03\0\0\0\x01\0", 9) + orientation + std::string("\0\0\0\0\0\0", 6) + name;
}

TEST(Names, OfJpeg) {
  const std::string start = "\xFF\xD8",
                    jfif = segment('\xE0', std::string("JFIF\0\1\1\1\1\x2c\1\x2c\0\0", 14));
  const std::string scan =
      segment('\xDA', "abc") + std::string("data\xFF\0data\xFF\xD0more", 15) + "\xFF\xD9";
  const std::string in =
      start + jfif + segment('\xE1', exif(1)) + segment('\xED', name) + segment('\xFE', name) + scan + name;
  EXPECT_EQ(blanked(in, "jpg"), start + jfif + segment('\xE1', std::string(exif(1).size(), '\0')) +
                                    segment('\xED', std::string(name.size(), '\0')) +
                                    segment('\xFE', std::string(name.size(), '\0')) + scan +
                                    std::string(name.size(), '\0'));
  // A photograph stays upright.
  const std::string turned = blanked(start + jfif + segment('\xE1', exif(6)) + scan, "jpg");
  EXPECT_NE(turned.find(std::string("\x01\x12\0\x03\0\0\0\x01\0\x06", 10)), std::string::npos);
}

TEST(Names, OfNothingThatItDoesNotKnow) {
  for (const std::string& bytes :
       {std::string(), std::string("This is a letter.\n"), std::string("PK\x03\x04") + std::string(200, '\0'),
        std::string("glTF") + std::string(200, '\x01'), std::string("<svg><!-- # --></svg>")})
    for (const char* extension : {"stl", "obj", "glb", "svg", ""})
      EXPECT_EQ(blanked(bytes, extension), bytes) << extension;
}

// Whatever the bytes, as many come out as went in.
TEST(Names, OfNoiseKeepTheirLength) {
  std::uint32_t state = 1;
  for (const std::string& begin :
       {std::string("\x89PNG\r\n\x1a\n"), std::string("\xff\xd8\xff\xe1"), std::string("ply\n"),
        std::string("solid "), std::string("v 1"), std::string("OFF\n")})
    for (int round = 0; round < 50; ++round) {
      std::string bytes = begin;
      const std::string_view letters = "v f#\\\n\r\to1solid facet comment end_header";
      for (int i = 0; i < 400; ++i) {
        const unsigned random = (state = state * 1664525u + 1013904223u) >> 24;
        bytes += round % 2 == 0 ? static_cast<char>(random) : letters[random % letters.size()];
      }
      for (const char* extension : {"stl", "obj"}) blanked(bytes, extension);
    }
}

}  // namespace
}  // namespace vacuform
