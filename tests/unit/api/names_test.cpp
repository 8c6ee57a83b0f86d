// Names in files are blanked and nothing else is: the same bytes out, but for those that may name someone.
#include "api/redaction/names.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

const std::string name = "JaneDoe1984";

// A new filter goes on with each piece, from what the one before it remembered.
std::string with_breaks(const std::string& bytes, const std::string& extension, std::size_t step) {
  std::string out, state = NameFilter(extension).state();
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    NameFilter filter(extension);
    EXPECT_TRUE(filter.go_on(state));
    out += filter.pass(std::string_view(bytes).substr(at, step));
    state = filter.state();
  }
  NameFilter filter(extension);
  EXPECT_TRUE(filter.go_on(state));
  return out + filter.finish();
}

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
  for (const std::size_t step : {1, 13, 84}) EXPECT_EQ(with_breaks(bytes, extension, step), out) << step;
  EXPECT_EQ(in_steps(out, 64), out);
  EXPECT_EQ(out.size(), bytes.size());
  EXPECT_EQ(out.find(name), std::string::npos);
  std::vector<std::uint8_t> whole(bytes.begin(), bytes.end());
  EXPECT_TRUE(blank_names(whole, "Scan of " + name + "." + extension));
  EXPECT_EQ(std::string(whole.begin(), whole.end()), out);
  return out;
}

std::string padded(std::string text, std::size_t size) { return text.append(size - text.size(), ' '); }
std::string blanks(std::size_t n) { return std::string(n, ' '); }

TEST(Names, AreBlankedInBinaryStl) {
  const std::string body = std::string("\x01\0\0\0", 4) + std::string(50, '\x07');
  for (const std::string& head : {padded(name, 80), padded("solid " + name, 80)})
    for (const char* extension : {"stl", ""}) {
      EXPECT_EQ(blanked(head + body, extension), blanks(80) + body);
      EXPECT_EQ(blanked(head + body + name, extension), blanks(80) + body + std::string(name.size(), '\0'));
    }
}

TEST(Names, AreBlankedInTextStl) {
  const std::string facets =
      "facet normal 0 0 1\n outer loop\n  vertex 1 2 3\n  vertex 1e-3 2 3\n  vertex 3 3 3\n "
      "endloop\nendfacet\n";
  EXPECT_EQ(blanked("solid " + name + " by\n" + name + "\r\n" + facets + "endsolid " + name, "stl"),
            "solid " + blanks(name.size() + 3) + "\n" + blanks(name.size()) + "\r\n" + facets + "endsolid " +
                blanks(name.size()));
  EXPECT_EQ(blanked("solid" + name + "\n" + facets, "stl"), "solid" + blanks(name.size()) + "\n" + facets);
  // After the facets, too, a name may go over several lines, and a reader quotes what it refuses.
  EXPECT_EQ(blanked("solid x\n" + facets + "endsolid x\nJane Doe\nsolid Jane\nDoe\n", "stl"),
            "solid  \n" + facets + "endsolid  \n        \nsolid     \n   \n");
  EXPECT_EQ(blanked("solid x\n" + facets + "nonsense 7\n", "stl"), "solid  \n" + facets + "          \n");
}

TEST(Names, AreBlankedInObj) {
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

TEST(Names, AreBlankedInPlyAndOff) {
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

TEST(Names, AreBlankedInPng) {
  const std::string signature = "\x89PNG\r\n\x1a\n", end = chunk("IEND", "", 0xAE426082);
  const std::string picture =
      chunk("IHDR", std::string(13, '\x01'), 1) + chunk("IDAT", "tEXt" + std::string(60, 'x'), 2);
  const std::string text = "Author" + std::string(1, '\0') + name;
  for (const char* type : {"tEXt", "zTXt", "iTXt", "eXIf", "tIME", "iCCP", "sPLT", "caNv"}) {
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

TEST(Names, AreBlankedInJpeg) {
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
  // A small picture of the picture goes, its density stays.
  const std::string thumbnail = std::string("JFIF\0\1\1\1\1\x2c\1\x2c\1\1", 14) + name;
  EXPECT_EQ(blanked(start + segment('\xE0', thumbnail) + segment('\xE0', std::string("JFXX\0", 5) + name) +
                        segment('\xEE', std::string("Adobe\0d\0\0\0\0\1", 12) + name) + scan,
                    "jpg"),
            start + segment('\xE0', thumbnail.substr(0, 14) + std::string(name.size(), '\0')) +
                segment('\xE0', std::string(5 + name.size(), '\0')) +
                segment('\xEE', std::string("Adobe\0d\0\0\0\0\1", 12) + std::string(name.size(), '\0')) +
                scan);
  // A photograph stays upright.
  const std::string turned = blanked(start + jfif + segment('\xE1', exif(6)) + scan, "jpg");
  EXPECT_NE(turned.find(std::string("\x01\x12\0\x03\0\0\0\x01\0\x06", 10)), std::string::npos);
}

std::string little_endian(std::size_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xFF);
  return bytes;
}
std::string glb(const std::string& json, const std::string& binary) {
  const std::string chunks = little_endian(json.size()) + "JSON" + json +
                             std::string((4 - json.size() % 4) % 4, ' ') + little_endian(binary.size()) +
                             std::string("BIN\0", 4) + binary;
  return "glTF" + little_endian(2) + little_endian(12 + chunks.size()) + chunks;
}

TEST(Names, AreBlankedInGlb) {
  const auto json = [](const std::string& text, const std::string& nought) {
    return R"({"asset":{"version":"2.0","generator":")" + text + R"(","copyright":")" + text +
           R"(","extras":)" + nought + R"(},"extensionsUsed":["KHR_lights_punctual"],"nodes":[{"name":")" +
           text + R"(","mesh":0,"extras":)" + nought +
           R"(}],"accessors":[{"bufferView":0,"type":"VEC3","name":")" + text +
           R"("}],"bufferViews":[{"byteLength":4,"buffer":0},{"byteOffset":4,"byteLength":)" +
           std::to_string(name.size()) + R"(}],"images":[{"bufferView":1,"name":")" + text +
           R"("},{"bufferView":0}]})";
  };
  const std::string escaped = R"(a\"b \\)" + name, quoted = R"({"who \" }":[1,{")" + name + R"(":true}]})";
  EXPECT_EQ(blanked(glb(json(escaped, quoted), "vert" + name + "rest") + name, "glb"),
            glb(json(blanks(escaped.size()), std::string("0") + blanks(quoted.size() - 1)),
                "vert" + std::string(name.size(), '\0') + "rest") +
                std::string(name.size(), '\0'));
  for (const std::string& value : std::vector<std::string>{"-12", "true", std::string("\"") + name + "\"",
                                                           std::string("[\"") + name + "\",[]]", "null"})
    EXPECT_EQ(blanked(glb(std::string("{\"extras\":") + value + " ,\"scene\":7}", ""), ""),
              glb(std::string("{\"extras\":0") + blanks(value.size()) + ",\"scene\":7}", ""));
}

TEST(Names, LeaveThePixelsOfTexturesInGlb) {
  const std::string text = "Author" + std::string(1, '\0') + name;
  const std::string png = "\x89PNG\r\n\x1a\n" + chunk("tEXt", text, 3) +
                          chunk("IDAT", std::string(60, 'x'), 2) + chunk("IEND", "", 0xAE426082);
  const std::string jpeg =
      "\xff\xd8" + segment('\xfe', name) + segment('\xda', "scan") + std::string(40, 'x') + "\xff\xd9";
  const std::string webp = "RIFF....WEBP" + name;
  for (const auto& [picture, kept] : {std::pair{png, blanked(png, "png")},
                                      {jpeg, blanked(jpeg, "jpg")},
                                      {webp, std::string(webp.size(), '\0')}}) {
    const std::string json =
        R"({"accessors":[{"bufferView":0}],"bufferViews":[{"byteLength":4},{"byteOffset":4,)"
        R"("byteLength":)" +
        std::to_string(picture.size()) + R"(}],"images":[{"bufferView":1}]})";
    EXPECT_EQ(blanked(glb(json, "vert" + picture + "rest"), "glb"), glb(json, "vert" + kept + "rest"));
    EXPECT_EQ(kept.find("xxxx") == std::string::npos, picture == webp);
  }
}

TEST(Names, AreBlankedInSvg) {
  const std::string gone = blanks(name.size());
  const auto drawing = [](const std::string& text, const std::string& comment) {
    return "\xef\xbb\xbf<?xml version='1.0'?>\n<?who " + text + "?><!--" + comment +
           "-->\n<!DOCTYPE svg [<!ENTITY ns 'http://ns'>]>\n"
           "<svg xmlns='http://www.w3.org/2000/svg' xmlns:s='http://s' s:docname='" +
           text + "' width='9mm' data-owner='" + text + "'>\n<title>" + text + "</title><desc>" + text +
           "</desc><metadata><r about='" + text + "'>" + text + "</r></metadata>\n<style>g{fill:red/*" +
           text + "*/}</style>\n<s:view name='a'>" + text + "</s:view><g id='Coil 1' class='c' s:label=\"" +
           text + "\"><path d='M0 0L1 1'/>" + text + "<text>Coil <title>" + text +
           "</title>1</text></g>\n<use href='#a'/><image href='" + text + "'/></svg>\n";
  };
  // The name of an element of another namespace hides its attributes too.
  std::string expected = drawing(gone, gone);
  expected.replace(expected.find("name='a'"), 8, "name=' '");
  EXPECT_EQ(blanked(drawing(name, name), "svg"), expected);
  EXPECT_EQ(blanked("<svg><!----" + name + "- --></svg>", ""), "<svg><!--  " + gone + "  --></svg>");
  const std::string other =
      "<d:svg xmlns:d='x' xmlns:e='http://www.w3.org/2000/svg'><d:g id='a'/><e:text>b</e:text></d:svg>";
  EXPECT_EQ(blanked(other, "svg"), other);
}

// By "base64" of coreutils.
TEST(Names, AreBlankedInPicturesOfSvg) {
  const std::string begin = "<svg><image href='data:image/jpeg;base64,", end = "'/></svg>";
  // FF D8 FF FE 00 0D "JaneDoe1984" FF DA 00 02 78 FF D9
  EXPECT_EQ(blanked(begin + "/9j//gANSmFuZURvZTE5ODT/2gACeP/Z" + end, "svg"),
            begin + "/9j//gANAAAAAAAAAAAAAAD/2gACeP/Z" + end);
  EXPECT_EQ(blanked(begin + "/9j//gANSmFu&#10;ZURvZTE5ODT/\n2gACeHj/2Q==" + end, "svg").size(),
            (begin + "/9j//gANSmFu&#10;ZURvZTE5ODT/\n2gACeHj/2Q==" + end).size());
  std::string lines = begin;  // of a long picture, as drawing programs break them
  for (int i = 0; i < 40; ++i)
    lines += "/9j//gANSmFuZURvZTE5ODT/2gACeHj/2gACeHh4\n" + std::string(i % 2 ? "  " : "&#10;");
  const std::string kept = blanked(lines + end, "svg");
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (lines[i] == '\n' || lines[i] == '&' || lines[i] == ';') {
      EXPECT_EQ(kept[i], lines[i]) << i;
    }
  for (const char* odd : {"", "A", "/9j/4Q", "/9j/4QA=", "=", "/9j=Jane"}) blanked(begin + odd + end, "svg");
}

TEST(Names, AreBlankedInTables) {
  EXPECT_EQ(
      blanked("# " + name + "\n120,121 # no remark\n \t#" + name + "\r\n122,123\n", "csv"),
      blanks(2 + name.size()) + "\n120,121 # no remark\n \t" + blanks(1 + name.size()) + "\r\n122,123\n");
  EXPECT_EQ(blanked("\xef\xbb\xbf# " + name + "\n1\n", "txt"),
            "\xef\xbb\xbf  " + blanks(name.size()) + "\n1\n");
}

TEST(Names, AreLeftInUnknownFormats) {
  for (const std::string& bytes :
       {std::string(), std::string("This is a letter.\n"), std::string("PK\x03\x04") + std::string(200, '\0'),
        std::string("glTF") + std::string(200, '\x01'), std::string("<svg><g id='coil'>\n</g></svg>")})
    for (const char* extension : {"stl", "obj", "glb", "svg", ""})
      EXPECT_EQ(blanked(bytes, extension), bytes) << extension;
}

// Whatever the bytes, as many come out as went in.
TEST(Names, KeepTheLengthOfNoise) {
  std::uint32_t state = 1;
  for (const std::string& begin :
       {std::string("\x89PNG\r\n\x1a\n"), std::string("\xff\xd8\xff\xe1"), std::string("ply\n"),
        std::string("solid "), std::string("v 1"), std::string("OFF\n"), std::string("<svg "), glb("", ""),
        std::string("<svg><image href='data:image/png;base64,iVBORw0KGgo")})
    for (int round = 0; round < 50; ++round) {
      std::string bytes = begin;
      const std::string_view letters =
          "v f#\\\n\r\to1solid facet comment end_header<!--->?='\"/:[]{}&;extras";
      for (int i = 0; i < 400; ++i) {
        const unsigned random = (state = state * 1664525u + 1013904223u) >> 24;
        bytes += round % 2 == 0 ? static_cast<char>(random) : letters[random % letters.size()];
      }
      for (const char* extension : {"stl", "obj"}) blanked(bytes, extension);
    }
}

}  // namespace
}  // namespace vacuform
