// Names in files go and nothing else does: the same geometry, pixels and drawing come out.
#include "api/redaction/redaction.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

const std::string name = "JaneDoe1984";

// Gives its bytes in pieces of so many.
class Pieces : public ByteSource {
 public:
  Pieces(const std::string& bytes, std::size_t step) : bytes_(bytes), step_(step) {}
  Result<std::uint64_t> size() const override { return bytes_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    if (offset >= bytes_.size()) return 0;
    return bytes_.copy(into.data(), std::min(step_, into.size()), static_cast<std::size_t>(offset));
  }

 private:
  const std::string& bytes_;
  const std::size_t step_;
};

Result<std::string> in_steps(const std::string& bytes, const std::string& extension, std::size_t step) {
  std::string out;
  const auto keep = [&](std::string_view piece) -> Result<void> {
    out += piece;
    return {};
  };
  VACUFORM_CHECK(redact(Pieces(bytes, step), extension, keep));
  return out;
}

// The copy must be the same for every way in which the bytes may come; a second time changes nothing.
std::string redacted(const std::string& bytes, const std::string& extension) {
  const auto out = in_steps(bytes, extension, bytes.size() + 1);
  EXPECT_TRUE(out) << out.error().text();
  if (!out) return {};
  for (const std::size_t step : {1, 7, 84, 85})
    EXPECT_EQ(in_steps(bytes, extension, step).value_or("refused"), *out) << step;
  EXPECT_EQ(in_steps(*out, extension, 64).value_or("refused"), *out);
  EXPECT_EQ(out->find(name), std::string::npos);
  std::vector<std::uint8_t> whole(bytes.begin(), bytes.end());
  EXPECT_TRUE(redact(whole, "Scan of " + name + "." + extension));
  EXPECT_EQ(std::string(whole.begin(), whole.end()), *out);
  return *out;
}
Error refusal(const std::string& bytes, const std::string& extension) {
  const auto out = in_steps(bytes, extension, 64);
  EXPECT_FALSE(out);
  return out ? Error() : out.error();
}

std::string padded(std::string text, std::size_t size) { return text.append(size - text.size(), ' '); }
std::string blanks(std::size_t n) { return std::string(n, ' '); }

std::string little_endian(std::size_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xFF);
  return bytes;
}
std::string glb(const std::string& json, const std::string& binary) {
  const std::string text = json + std::string((4 - json.size() % 4) % 4, ' ');
  const std::string chunks = little_endian(text.size()) + "JSON" + text + little_endian(binary.size()) +
                             std::string("BIN\0", 4) + binary;
  return "glTF" + little_endian(2) + little_endian(12 + chunks.size()) + chunks;
}

TEST(Redaction, RemovesNamesFromBinaryStl) {
  const std::string body = std::string("\x01\0\0\0", 4) + std::string(50, '\x07');
  for (const std::string& head : {padded(name, 80), padded("solid " + name, 80)})
    for (const char* extension : {"stl", ""}) {
      EXPECT_EQ(redacted(head + body, extension), blanks(80) + body);
      EXPECT_EQ(redacted(head + body + name, extension), blanks(80) + body);
    }
}

std::string stl_body(char count, std::size_t triangles) {
  return std::string(1, count) + std::string(3, '\0') + std::string(50 * triangles, '\x07');
}

TEST(Redaction, KeepsWhatTheReaderFindsInABinaryStlByItsSize) {
  // A count that is too small, none, and one that was never written.
  for (const char count : {'\1', '\0'})
    EXPECT_EQ(redacted(padded(name, 80) + stl_body(count, 3), "stl"), blanks(80) + stl_body(count, 3));
  const std::string unknown = std::string(4, '\xff') + std::string(150, '\x07');
  EXPECT_EQ(redacted(padded(name, 80) + unknown, "stl"), blanks(80) + unknown);
  // A second body loses its names, too, and so does what is no body.
  const std::string two = stl_body(2, 2), one = stl_body(1, 1);
  EXPECT_EQ(redacted(padded(name, 80) + two + padded("by " + name, 80) + one, "stl"),
            blanks(80) + two + blanks(80) + one);
  EXPECT_EQ(redacted(padded(name, 80) + one + padded(name, 100), "stl"), blanks(80) + one);
  EXPECT_EQ(redacted(padded(name, 80) + one + name + std::string(40, '\x01'), "stl"),
            blanks(80) + one + std::string(40 + name.size(), '\x7f'));
}

TEST(Redaction, KeepsTheAxesOfThePatientAlone) {
  const std::string body = stl_body(1, 1), said = name + " 3D Slicer output. SPACE=LPS " + name;
  EXPECT_EQ(redacted(padded(said, 80) + body, "stl"), padded("SPACE=LPS", 80) + body);
  EXPECT_EQ(redacted(padded("aerospace=LPS SPACE=LPSX SPACE=Doe", 80) + body, "stl"), blanks(80) + body);
  EXPECT_EQ(redacted("solid " + name + " space=ras " + name + "\nendsolid x\n", "stl"),
            "solid " + blanks(name.size() + 1) + "SPACE=RAS" + blanks(name.size() + 1) + "\nendsolid  \n");
  EXPECT_EQ(redacted("# " + name + " SPACE=LPS\nv 1 2 3 # SPACE=LPS\n", "obj"),
            "# " + blanks(name.size() + 1) + "SPACE=LPS\nv 1 2 3 " + blanks(11) + "\n");
  EXPECT_NE(redacted("ply\nformat ascii 1.0\ncomment " + said + "\nelement vertex 0\nend_header\n", "ply")
                .find("\ncomment SPACE=LPS\nelement"),
            std::string::npos);
}

TEST(Redaction, KeepsTheSplitKeywordsOfTextStl) {
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 1 2 3\nend loop\nEND FACET\n";
  EXPECT_EQ(redacted("solid\n" + facet + "end solid " + name + "\n", "stl"),
            "solid\n" + facet + blanks(10 + name.size()) + "\n");
}

TEST(Redaction, KeepsWhatMovesTheVerticesOfAGlb) {
  const std::string moved =
      R"({"nodes":[{"mesh":0,"skin":0,"weights":[0.5],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":)"
      R"({"TRANSLATION":0,"ROTATION":1,"SCALE":2}}}}],"skins":[{"joints":[0],"inverseBindMatrices":3}],)"
      R"("meshes":[{"weights":[1],"primitives":[{"attributes":{"JOINTS_0":4,"WEIGHTS_0":5},"targets":[{"POSITION":6}]}]}]})";
  EXPECT_EQ(redacted(glb(moved, ""), "glb"), glb(moved, ""));
}

TEST(Redaction, RemovesNamesFromTextStl) {
  const std::string facets =
      "facet normal 0 0 1\n outer loop\n  vertex 1 2 3\n  vertex 1e-3 2 3\n  vertex 3 3 3\n "
      "endloop\nendfacet\n";
  EXPECT_EQ(redacted("solid " + name + " by\n" + name + "\r\n" + facets + "endsolid " + name, "stl"),
            "solid " + blanks(name.size() + 3) + "\n" + blanks(name.size()) + "\r\n" + facets + "endsolid " +
                blanks(name.size()));
  EXPECT_EQ(redacted("solid" + name + "\n" + facets, "stl"), "solid" + blanks(name.size()) + "\n" + facets);
  // After the facets, too, a name may go over several lines, and a reader quotes what it refuses.
  EXPECT_EQ(redacted("solid x\n" + facets + "endsolid x\nJane Doe\nsolid Jane\nDoe\n", "stl"),
            "solid  \n" + facets + "endsolid  \n        \nsolid     \n   \n");
  EXPECT_EQ(redacted("solid x\n" + facets + "nonsense 7\n", "stl"), "solid  \n" + facets + "          \n");
}

TEST(Redaction, RemovesNamesFromObj) {
  const std::string kept = "v 1 2 3\nvn 0 0 1\nvt 0.5 0.25\nf 1/1/1 2/2/2 \\\n 3/3/3\ns off\n";
  EXPECT_EQ(redacted("# " + name + "\nmtllib " + name + ".mtl\no " + name + "\n" + kept + "v 1 2 3 # " +
                         name + "\n" + name + " 1\n",
                     "obj"),
            blanks(2 + name.size()) + "\nmtllib " + blanks(4 + name.size()) + "\no " + blanks(name.size()) +
                "\n" + kept + "v 1 2 3 " + blanks(2 + name.size()) + "\n" + blanks(name.size() + 2) + "\n");
  EXPECT_EQ(redacted("# \\\n" + name + "\nv 1 2 3\n", "obj"),
            blanks(3) + "\n" + blanks(name.size()) + "\nv 1 2 3\n");
  EXPECT_EQ(redacted("g " + name, ""), "g " + blanks(name.size()));
  // A word in place of a number is no number afterwards, either.
  EXPECT_EQ(redacted("v 1 Jane 3\nf 1/1 2/2 off\n", "obj"), "v 1 ???? 3\nf 1/1 2/2 off\n");
  EXPECT_EQ(redacted("\xef\xbb\xbfv 1 2 3\n", "obj"), "v 1 2 3\n");
}

TEST(Redaction, RemovesNamesFromOff) {
  EXPECT_EQ(
      redacted("OFF # " + name + "\n3 1 0\n0 0 0.123456789012345 #" + name + "\n", "off"),
      "OFF " + blanks(2 + name.size()) + "\n3 1 0\n0 0 0.123456789012345 " + blanks(1 + name.size()) + "\n");
  EXPECT_EQ(redacted("STOFF BINARY\n1 0 0\n0 nan 1e-3\n" + name + " Jane\n", "off"),
            "STOFF BINARY\n1 0 0\n0 nan 1e-3\n" + std::string(name.size(), '?') + " ????\n");
}

std::string ply(const std::string& format, const std::string& rows) {
  return "ply\nformat " + format +
         " 1.0\nelement vertex 2\nproperty uchar x\nproperty uchar y\n"
         "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n" +
         rows;
}

TEST(Redaction, RemovesNamesFromPly) {
  const std::string rows("\x01\x02\x03\x04\x02\x00\x01", 7);
  EXPECT_EQ(
      redacted("ply\r\nformat binary_big_endian 1.0\r\ncomment by " + name + "\r\nobj_info " + name +
                   "\r\nelement vertex 1\r\nproperty float x\r\nproperty double " + name + "\r\nelement " +
                   name + " 1\r\nproperty list ushort uchar " + name + "\r\n" + name +
                   " 1\r\nend_header\r\n" + std::string("float double\0\3end", 17) + name,
               "ply"),
      "ply\r\nformat binary_big_endian 1.0\r\ncomment\r\nobj_info\r\nelement vertex 1\r\nproperty float x\r\n"
      "property double other\r\nelement other 1\r\nproperty list ushort uchar other\r\n?\r\nend_header\r\n" +
          std::string("float double\0\3end", 17));
  for (const char* format : {"binary_little_endian", "binary_big_endian"})
    EXPECT_EQ(redacted(ply(format, rows + name), "ply"), ply(format, rows));
  EXPECT_EQ(redacted(ply("ascii", "1 2\n3 4\n2 0 1\n" + name + "\n1984\n"), "ply"),
            ply("ascii", "1 2\n3 4\n2 0 1\n"));
  EXPECT_EQ(redacted(ply("ascii", "1 2\n3 Jane\n2 0 1\n"), "ply"), ply("ascii", "1 2\n3 ?\n2 0 1\n"));
  // A list that is longer than the file, and a header without an end.
  redacted(ply("binary_little_endian", "\x01\x02\x03\x04\xff" + name.substr(0, 4)), "ply");
  redacted("ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty list int int x\nend_header\n-5 4",
           "ply");
  redacted("ply\nelement vertex 1\n" + name, "ply");
}

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xFF);
  return bytes;
}
std::string chunk(const std::string& type, const std::string& data, std::uint32_t crc) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc);
}

TEST(Redaction, RemovesNamesFromPng) {
  const std::string signature = "\x89PNG\r\n\x1a\n", end = chunk("IEND", "", 0xAE426082);
  const std::string picture =
      chunk("IHDR", std::string(13, '\x01'), 1) + chunk("IDAT", "tEXt" + std::string(60, 'x'), 2);
  const std::string text = "Author" + std::string(1, '\0') + name;
  for (const char* type : {"tEXt", "zTXt", "iTXt", "eXIf", "tIME", "iCCP", "sPLT", "caNv", "gAMA"})
    EXPECT_EQ(redacted(signature + chunk(type, text, 3) + picture + end + name, "png"),
              signature + picture + end)
        << type;
  const std::string colours = chunk("gAMA", "1234", 4) + chunk("pHYs", "123456789", 5);
  EXPECT_EQ(redacted(signature + colours + picture + end, ""), signature + colours + picture + end);
  // What every reader must know ends the picture.
  EXPECT_EQ(redacted(signature + picture + chunk("JANE", name, 3) + end, "png"),
            signature + picture + chunk("JANE", std::string(name.size(), '\0'), 3));
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

TEST(Redaction, RemovesNamesFromJpeg) {
  const std::string start = "\xFF\xD8",
                    jfif = segment('\xE0', std::string("JFIF\0\1\1\1\1\x2c\1\x2c\0\0", 14));
  const std::string scan =
      segment('\xDA', "abc") + std::string("data\xFF\0data\xFF\xD0more", 15) + "\xFF\xD9";
  const std::string in =
      start + jfif + segment('\xE1', exif(1)) + segment('\xED', name) + segment('\xFE', name) + scan + name;
  EXPECT_EQ(redacted(in, "jpg"), start + jfif + scan);
  // A small picture of the picture goes, its density stays.
  const std::string thumbnail = std::string("JFIF\0\1\1\1\1\x2c\1\x2c", 12),
                    adobe = std::string("Adobe\0d\0\0\0\0\1", 12);
  EXPECT_EQ(redacted(start + segment('\xE0', thumbnail + "\1\1" + name) +
                         segment('\xE0', std::string("JFXX\0", 5) + name) + segment('\xEE', adobe + name) +
                         name + scan,
                     "jpg"),
            start + segment('\xE0', thumbnail + std::string(2, '\0')) + segment('\xEE', adobe) + scan);
  EXPECT_EQ(redacted(start + segment('\xE0', "JFIF" + name).substr(0, 9), "jpg"),
            start + std::string("\xFF\xE0\0\x11", 4));
  // A photograph stays upright.
  const std::string turned = redacted(start + jfif + segment('\xE1', exif(6)) + scan, "jpg");
  EXPECT_NE(turned.find(std::string("\x01\x12\0\x03\0\0\0\x01\0\x06", 10)), std::string::npos);
}

TEST(Redaction, RemovesNamesFromGlb) {
  const std::string quoted = R"({"who \" }":[1,{")" + name + R"(":true}]})", escaped = R"(a\"b \\)" + name;
  const std::string in =
      R"({"asset":{"version":"2.0","generator":")" + escaped + R"(","extras":)" + quoted +
      R"(},"extensionsUsed":["KHR_lights_punctual",")" + name + R"("],")" + name + R"(":[[{")" + name +
      R"(":1}]],"extras":-1.5e3,"nodes":[{"name":")" + name +
      R"(","mesh":0,"matrix":[1,0.10,-2]},{"extras":null},{}],"accessors":[{"bufferView":0,"type":"VEC3"}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"_)" +
      name +
      R"(":1,"TEXCOORD_0":2}}]}],)"
      R"("bufferViews":[{"byteLength":4,"buffer":0},{"byteOffset":4,"byteLength":11},{"byteOffset":15,"byteLength":2}],)"
      R"("images":[{"bufferView":1,"uri":")" +
      name + R"("},{"bufferView":0}]})";
  const std::string out =
      R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual",""],"nodes":[{"mesh":0,"matrix":[1,0.10,-2]},{},{}],)"
      R"("accessors":[{"bufferView":0,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2}}]}],)"
      R"("bufferViews":[{"byteLength":4,"buffer":0},{"byteOffset":4,"byteLength":11},{"byteOffset":15,"byteLength":2}],)"
      R"("images":[{"bufferView":1,"uri":""},{"bufferView":0}]})";
  // The second view is no picture, and nobody uses the third one or what follows it.
  EXPECT_EQ(redacted(glb(in, "vert" + name + "xx" + name) + name, "glb"),
            glb(out, "vert" + std::string(24, '\0')));
  // Without binary data; broken JSON; and what is no GLB file of version 2.
  EXPECT_EQ(redacted(glb(R"({"scene":7})", ""), ""), glb(R"({"scene":7})", ""));
  const std::string older = "glTF" + little_endian(1) + std::string(200, 'J');
  EXPECT_EQ(redacted(older, "glb"), older);
  EXPECT_EQ(redacted(glb(R"({"scene":7,)" + name, "bytes"), "glb").size(), 32u);
  EXPECT_EQ(redacted(glb("{\"scene\":7}" + std::string(4, '\0'), ""), "glb"), glb(R"({"scene":7})", ""));
}

// It is refused, and its reader sees why.
TEST(Redaction, LeavesAGlbThatEndsTooEarly) {
  const std::string json = R"({"accessors":[{"bufferView":0}],"bufferViews":[{"byteLength":8}]})";
  const std::string whole = glb(json, "vertices"), cut = whole.substr(0, whole.size() - 4);
  EXPECT_EQ(redacted(whole, "glb"), whole);
  EXPECT_EQ(redacted(cut, "glb"), cut);
}

TEST(Redaction, LeavesThePixelsOfTexturesInGlb) {
  const std::string text = "Author" + std::string(1, '\0') + name;
  const std::string png = "\x89PNG\r\n\x1a\n" + chunk("tEXt", text, 3) +
                          chunk("IDAT", std::string(60, 'x'), 2) + chunk("IEND", "", 0xAE426082);
  const std::string jpeg =
      "\xff\xd8" + segment('\xfe', name) + segment('\xda', "scan") + std::string(40, 'x') + "\xff\xd9";
  const std::string webp = "RIFF....WEBP" + name;
  for (const auto& [picture, kept] :
       {std::pair{png, redacted(png, "png")}, {jpeg, redacted(jpeg, "jpg")}, {webp, std::string()}}) {
    const std::string json =
        R"({"accessors":[{"bufferView":0},{"bufferView":2}],"bufferViews":[{"byteLength":4},{"byteOffset":4,)"
        R"("byteLength":)" +
        std::to_string(picture.size()) + R"(},{"byteOffset":)" + std::to_string(picture.size() + 4) +
        R"(,"byteLength":4}],"images":[{"bufferView":1}]})";
    EXPECT_EQ(redacted(glb(json, "vert" + picture + "rest"), "glb"),
              glb(json, "vert" + kept + std::string(picture.size() - kept.size(), '\0') + "rest"));
    EXPECT_EQ(kept.find("xxxx") == std::string::npos, picture == webp);
  }
}

const std::string svg_head =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
    "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\"";

// The drawing `inside` an SVG file, as it comes out.
std::string drawing(const std::string& inside, const std::string& root = "") {
  const std::string out =
      redacted("<svg xmlns='http://www.w3.org/2000/svg'" + root + ">" + inside + "</svg>", "svg");
  const std::size_t begin = svg_head.size() + 1;
  if (out.size() < begin + 6 || !out.starts_with(svg_head)) return out;
  return out.substr(begin, out.size() - begin - 6);
}

TEST(Redaction, RemovesNamesFromSvg) {
  const std::string in = "\xef\xbb\xbf<?xml version='1.0'?>\n<?who " + name + "?><!--" + name +
                         "-->\n<!DOCTYPE svg [<!ENTITY ns 'http://" + name + "'><!ENTITY who \"" + name +
                         "\">]>\n"
                         "<svg xmlns='http://www.w3.org/2000/svg' xmlns:s='&ns;' s:docname='" +
                         name + "' width='9mm' data-owner='" + name + "' owner='" + name + "'>\n<title>" +
                         name + "</title><desc>" + name + "</desc><metadata><r about='" + name + "'>" + name +
                         "</r></metadata>\n<style>g{fill:red/*" + name + "*/}</style>\n<s:view name='a'>" +
                         name + "</s:view><g id='Coil 1' class='c' s:label=\"" + name + "\"\n onclick='" +
                         name + "'><path d='M0 0L1 1'/>" + name + "<text>Coil <title>" + name +
                         "</title>1</text></g>\n<use href='#a'/><image href='" + name + "'/></svg>\n";
  EXPECT_EQ(redacted(in, "svg"),
            "\n\n\n" + svg_head +
                " width=\"9mm\">\n\n<style>g{fill:red}</style>\n<g id=\"Coil 1\" class=\"c\">\n"
                "<path d=\"M0 0L1 1\"></path><text>Coil 1</text></g>\n<use href=\"#a\"></use><image href=\" "
                "\"></image></svg>");
}

TEST(Redaction, RemovesTextsOfSvgThatNobodySees) {
  const std::string text = "<text>" + name + "</text>", empty = "<text></text>";
  EXPECT_EQ(drawing("<g display='none'>" + text + "<text display='inline'>" + name + "</text></g>"),
            "<g display=\"none\">" + empty + "<text display=\"inline\"></text></g>");
  EXPECT_EQ(drawing("<g style='fill:red; display : none'>" + text + "</g>"),
            "<g style=\"fill:red; display : none\">" + empty + "</g>");
  EXPECT_EQ(drawing("<text opacity='0'>" + name + "</text>"), "<text opacity=\"0\"></text>");
  // A sheet hides it that may come after it.
  EXPECT_EQ(
      drawing("<g class='a st0'>" + text + "</g><style>.b{x:y}.c , .st0 {stroke:red;display: none}</style>"),
      "<g class=\"a st0\">" + empty + "</g><style>.b{x:y}.c , .st0 {stroke:red;display: none}</style>");
  // <use> shows it all the same.
  EXPECT_EQ(drawing("<g display='none'><text id='a'>Coil</text></g><use href='#a'/>"),
            "<g display=\"none\"><text id=\"a\">Coil</text></g><use href=\"#a\"></use>");
}

TEST(Redaction, KeepsWhatDrawsInSvg) {
  EXPECT_EQ(drawing("<g style='fill:red;-inkscape-font-specification:" + name + ";stroke:none;'/>"),
            "<g style=\"fill:red;stroke:none\"></g>");
  EXPECT_EQ(drawing("<g fill='url(#a)' style='stroke:url(\"#b\");fill:url(http://" + name + ")'/>"),
            "<g fill=\"url(#a)\" style=\"stroke:url(&quot;#b&quot;);fill:url()\"></g>");
  EXPECT_EQ(drawing("<i:g i:groupmode='layer' i:label='" + name + "'/><g i:groupmode='layer' i:label='" +
                        name + "'/>",
                    " xmlns:i='http://www.inkscape.org/namespaces/inkscape'"),
            "<g inkscape:groupmode=\"layer\"></g>");
  // Where a layout put a coil; a word in its place goes.
  EXPECT_EQ(drawing("<g data-place='1.5 -2 80 0 1e0 0 3 4'/><g data-place='" + name + "'/>"),
            "<g data-place=\"1.5 -2 80 0 1e0 0 3 4\"></g><g></g>");
  EXPECT_EQ(drawing("<switch><foreignObject requiredExtensions='http://" + name +
                        "'><i:x/></foreignObject><g/></switch>",
                    " xmlns:i='x'"),
            "<switch><foreignObject requiredExtensions=\"unknown\"></foreignObject><g></g></switch>");
  EXPECT_EQ(drawing("<style><![CDATA[g > path {fill:red}]]></style><text>a &lt; b &amp; c</text>"),
            "<style>g &gt; path {fill:red}</style><text>a &lt; b &amp; c</text>");
  // Namespaces by other prefixes, by entities, and by nobody.
  EXPECT_EQ(redacted("<!DOCTYPE a:svg [<!ENTITY s 'http://www.w3.org/2000/svg'>]><a:svg xmlns:a='&s;'><a:g "
                     "id='x'/></a:svg>",
                     "svg"),
            svg_head + "><g id=\"x\"></g></svg>");
  EXPECT_EQ(redacted("<svg><use xlink:href='#a'/></svg>", "svg"),
            svg_head + "><use xlink:href=\"#a\"></use></svg>");
  // Other encodings become UTF-8.
  EXPECT_EQ(redacted("<?xml version='1.0' encoding='windows-1252'?><svg><text>\x80\xe9</text></svg>", "svg"),
            svg_head + "><text>\xe2\x82\xac\xc3\xa9</text></svg>");
  std::string wide = "\xff\xfe";
  for (const char c : std::string("<svg><g id='a'/></svg>")) wide += std::string{c, '\0'};
  EXPECT_EQ(redacted(wide, "svg"), svg_head + "><g id=\"a\"></g></svg>");
}

TEST(Redaction, RefusesWhatIsNoSvg) {
  EXPECT_EQ(refusal("<svg>\n<g></svg>", "svg").what, "the SVG cannot be read: mismatched tag, on line 2");
  EXPECT_EQ(refusal("<COLLADA/>", "svg").code, Code::unsupported_format);
  EXPECT_EQ(refusal("<d:svg xmlns:d='x'/>", "svg").code, Code::unsupported_format);
  EXPECT_EQ(
      refusal("<!DOCTYPE svg [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><svg><text>&x;</text></svg>", "svg")
          .code,
      Code::unsupported_format);
  std::string laughs = "<!DOCTYPE svg [<!ENTITY a0 'ha'>";
  for (int i = 1; i < 40; ++i) {
    const std::string last = "&a" + std::to_string(i - 1) + ";";
    laughs += "<!ENTITY a" + std::to_string(i) + " '" + last + last + "'>";
  }
  EXPECT_EQ(refusal(laughs + "]><svg><text>&a39;</text></svg>", "svg").code, Code::unsupported_format);
  std::string long_one = "<!DOCTYPE svg [<!ENTITY a '" + std::string(1000, 'x') + "'>]><svg><text>";
  for (int i = 0; i < 1000; ++i) long_one += "&a;";
  EXPECT_EQ(refusal(long_one + "</text></svg>", "svg").code, Code::too_large);
  std::string spaces = "<svg";
  for (int i = 0; i < 200; ++i) spaces += " xmlns:n" + std::to_string(i) + "='x'";
  EXPECT_EQ(refusal(spaces + "/>", "svg").code, Code::too_large);
}

// By "base64" of coreutils.
TEST(Redaction, RemovesNamesFromPicturesOfSvg) {
  const auto picture = [](const std::string& data) {
    return drawing("<image href='data:image/jpeg;base64," + data + "'/>");
  };
  const auto kept = [](const std::string& data) {
    return "<image href=\"data:image/jpeg;base64," + data + "\"></image>";
  };
  // FF D8 FF FE 00 0D "JaneDoe1984" FF DA 00 02 78 FF D9; without the comment.
  EXPECT_EQ(picture("/9j//gANSmFuZURvZTE5ODT/2gACeP/Z"), kept("/9j/2gACeP/Z"));
  EXPECT_EQ(picture("/9j//gANSmFu&#10;ZURvZTE5\nODT/2gACeP/Z"), kept("/9j/2gACeP/Z"));
  for (const char* odd : {"", "A", "/9j/4Q", "=", "/9j=Jane", "SmFuZURvZTE5ODQ="})
    EXPECT_EQ(picture(odd), kept("")) << odd;
  EXPECT_EQ(drawing("<image href='data:" + name + ",'/>"), "<image href=\"data:,\"></image>");
}

TEST(Redaction, RemovesNamesFromTables) {
  EXPECT_EQ(redacted("# " + name + "\n120,121 # Jane\n \t#" + name + "\r\n122;nan\n", "csv"),
            blanks(2 + name.size()) + "\n120,121 ? ????\n \t" + blanks(1 + name.size()) + "\r\n122;nan\n");
  const std::string points = "\"S_mm\",t, Celsius\n0,-3.5,140\n";
  EXPECT_EQ(redacted(points, "csv"), points);
  EXPECT_EQ(redacted("\xef\xbb\xbf# " + name + "\n1\n", "txt"), blanks(2 + name.size()) + "\n1\n");
}

TEST(Redaction, LeavesUnknownFormatsAlone) {
  for (const std::string& bytes :
       {std::string(), std::string("This is a letter.\n"), std::string("PK\x03\x04") + std::string(200, '\0'),
        std::string("<!DOCTYPE html><p>")})
    for (const char* extension : {"stl", "obj", "glb", "svg", ""})
      EXPECT_EQ(redacted(bytes, extension), bytes) << extension;
}

TEST(Redaction, RefusesALineWithoutEnd) {
  EXPECT_EQ(refusal("v 1 2 3 # " + std::string(std::size_t{17} << 20, 'x'), "obj").code, Code::too_large);
}

// Whatever the bytes, a copy comes out, or a refusal, and a second one is the same.
TEST(Redaction, TakesNoise) {
  std::uint32_t state = 1;
  for (const std::string& begin :
       {std::string("\x89PNG\r\n\x1a\n"), std::string("\xff\xd8\xff\xe1"),
        std::string("ply\nformat ascii 1.0\nelement vertex 9\nproperty list char int a\nend_header\n"),
        std::string("solid "), std::string("v 1"), std::string("OFF\n"), std::string("<svg "), glb("{}", ""),
        std::string("<svg><image href='data:image/png;base64,iVBORw0KGgo")})
    for (int round = 0; round < 50; ++round) {
      std::string bytes = begin;
      const std::string_view letters =
          "v f#\\\n\r\to1solid facet comment end_header<!--->?='\"/:[]{}&;extras";
      for (int i = 0; i < 400; ++i) {
        const unsigned random = (state = state * 1664525u + 1013904223u) >> 24;
        bytes += round % 2 == 0 ? static_cast<char>(random) : letters[random % letters.size()];
      }
      for (const char* extension : {"stl", "obj"}) {
        const auto out = in_steps(bytes, extension, 33);
        if (out) redacted(bytes, extension);
      }
    }
}

}  // namespace
}  // namespace vacuform
