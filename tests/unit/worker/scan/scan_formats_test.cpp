// Every format, from a cube of 100 mm; and every way in which a file can lie.
#include <gtest/gtest.h>

#include "api/problem.hpp"
#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/welding.hpp"

namespace vacuform::scan_formats_test {
namespace {

using namespace shapes;

Result<ScanFile> read(const FileBytes& bytes, const std::string& name) {
  const Context context;
  return read_scan(bytes, name, ScanProgress(context));
}

struct CubeFile {
  const char* name;    // as the user calls it; the bytes must tell
  const char* format;  // as reported
  FileBytes bytes;
};
void PrintTo(const CubeFile& file, std::ostream* out) { *out << file.format; }

class CubeFormat : public testing::TestWithParam<CubeFile> {};

TEST_P(CubeFormat, IsTheSameCube) {
  auto scan = read(GetParam().bytes, GetParam().name);
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->format, GetParam().format);
  EXPECT_EQ(scan->mesh.triangles.size(), 12u);
  weld(scan->mesh, 0);
  EXPECT_EQ(scan->mesh.vertices.size(), 8u);
  EXPECT_TRUE(is_watertight(scan->mesh));
  EXPECT_NEAR(signed_volume(scan->mesh), 1e6, 1e-6);
  EXPECT_EQ(bounds(scan->mesh).low, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(bounds(scan->mesh).high, Eigen::Vector3d(100, 100, 100));

  const auto mold = make_mold(GetParam().bytes, GetParam().name, {}, Context());
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_TRUE(is_watertight(mold->mesh));
  EXPECT_NEAR(signed_volume(mold->mesh), 1e6, 1);
  EXPECT_EQ(mold->findings.trim_mm, 0);
  EXPECT_TRUE(mold->undercuts.empty());
}

FileBytes solid_binary() {
  auto bytes = stl(cube(100));
  const std::string header = "solid facet normal endsolid vertex";
  std::copy(header.begin(), header.end(), bytes.begin());
  return bytes;
}
FileBytes trailing_binary() {
  auto bytes = stl(cube(100));
  bytes.insert(bytes.end(), 33, 0);
  return bytes;
}
FileBytes long_name_ascii() {
  auto bytes = stl_ascii(cube(100));
  bytes.insert(bytes.begin() + 6, 300'000, 'n');
  return bytes;
}
FileBytes with_crlf(const FileBytes& text) {
  FileBytes out;
  for (const auto c : text) {
    if (c == '\n') out.push_back('\r');
    out.push_back(c);
  }
  return out;
}
const char* const quad_corners =
    "0 0 0\n100 0 0\n0 100 0\n100 100 0\n0 0 100\n100 0 100\n0 100 100\n100 100 100\n";
FileBytes quad_obj() {
  std::string text = "mtllib cube.mtl\no cube\nvn 0 0 1\nvt 0 0\n", corners = quad_corners;
  for (std::size_t at = 0; at < corners.size(); at = corners.find('\n', at) + 1)
    text += "v " + corners.substr(at, corners.find('\n', at) - at) + " 1 0.5 0.5\n";  // with colours
  return text_bytes(text +
                    "f 1/1/1 3/1/1 4/1/1 2/1/1\nf 5//1 6//1 8//1 7//1\nf -8 -7 -3 -4\nf -6 -2 -1 \\\n -5\nf "
                    "1 5 7 3 # side\nf 2/ 4/ 8/ 6/");
}
FileBytes quad_ply() {
  return text_bytes(
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double "
      "z\nelement face 6\n"
      "property uchar red\nproperty list uchar uint vertex_indices\nproperty list uchar float "
      "texcoord\nend_header\n" +
      std::string(quad_corners) +
      "1 4 0 2 3 1 2 .5 .5\n1 4 4 5 7 6 0\n1 4 0 1 5 4 0\n1 4 2 6 7 3 0\n1 4 0 4 6 2 0\n1 4 1 3 7 5 0");
}
FileBytes quad_off() {
  return text_bytes(
      "COFF 8 6 12\n0 0 0 1 1 1 1\n100 0 0 1 1 1 1\n0 100 0 1 1 1 1\n\n100 100 0 1 1 1 1 # corner\n0 0 100 1 "
      "1 1 1\n"
      "100 0 100 1 1 1 1\n0 100 100 1 1 1 1\n100 100 100 1 1 1 1\n"
      "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5");
}
// Twelve triangles without indices, in metres, under two nodes of which the outer mirrors.
FileBytes plain_glb() {
  FileBytes binary;
  const auto mesh = cube(1);
  for (const auto& t : mesh.triangles)
    for (const int v : t)
      for (int k = 0; k < 3; ++k) put_float(binary, mesh.vertices[static_cast<std::size_t>(v)][k]);
  return glb(
      "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0,\"translation\":[-1,0,0]},{\"scale\":[-100,"
      "100,100],\"children\":[0]}],"
      "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
      "\"componentType\":5126,"
      "\"count\":36,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":432}],\"buffers\":[{"
      "\"byteLength\":432}]}",
      binary);
}
// The cube's six faces: a fan, a strip and four lists of bytes as indices, all over one accessor of
// positions.
FileBytes strips_glb() {
  FileBytes binary;
  for (const auto& p : cube(100).vertices)
    for (int k = 0; k < 3; ++k) put_float(binary, p[k]);
  for (const int v : {0,
                      2,
                      3,
                      1,
                      /* strip */ 4,
                      5,
                      6,
                      7,
                      /* lists */ 0,
                      1,
                      5,
                      0,
                      5,
                      4,
                      2,
                      6,
                      7,
                      2,
                      7,
                      3,
                      0,
                      4,
                      6,
                      0,
                      6,
                      2,
                      1,
                      3,
                      7,
                      1,
                      7,
                      5})
    put(binary, static_cast<std::uint64_t>(v), 1);
  const auto indices = [](int offset, int count) {
    return "{\"bufferView\":1,\"byteOffset\":" + std::to_string(offset) +
           ",\"componentType\":5121,\"count\":" + std::to_string(count) + ",\"type\":\"SCALAR\"}";
  };
  const auto primitive = [](int mode, int accessor) {
    return "{\"mode\":" + std::to_string(mode) +
           ",\"attributes\":{\"POSITION\":0},\"indices\":" + std::to_string(accessor) + "}";
  };
  return glb(
      "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_materials_unlit\"],\"scenes\":[{"
      "\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
      "\"meshes\":[{\"primitives\":[" +
          primitive(6, 1) + "," + primitive(5, 2) + "," + primitive(4, 3) +
          "]}],\"accessors\":["
          "{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"}," +
          indices(0, 4) + "," + indices(4, 4) + "," + indices(8, 24) +
          "],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":"
          "32}],\"buffers\":[{\"byteLength\":128}]}",
      binary);
}

// Two strips of a cube's sides and lids, with a restart between them, in one list or two.
FileBytes strip_ply(const std::string& format, bool two_lists) {
  const std::vector<int> sides{4, 0, 5, 1, 7, 3, 6, 2, 4, 0}, lids{0, 2, 1, 3, -1, 4, 5, 6, 7};
  std::vector<std::vector<int>> lists{sides, lids};
  if (!two_lists) {
    lists[0].push_back(-1);
    lists[0].insert(lists[0].end(), lids.begin(), lids.end());
    lists.pop_back();
  }
  auto bytes =
      text_bytes("ply\nformat " + format +
                 " 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float "
                 "z\nelement tristrips " +
                 std::to_string(lists.size()) + "\nproperty list int int vertex_indices\nend_header\n");
  const bool ascii = format == "ascii", big = format == "binary_big_endian";
  const auto put_int = [&](int value) {
    if (!ascii) return put(bytes, static_cast<std::uint32_t>(value), 4, big);
    const auto word = text_bytes(std::to_string(value) + " ");
    bytes.insert(bytes.end(), word.begin(), word.end());
  };
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) {
      const int x = i >> k & 1 ? 100 : 0;
      ascii ? put_int(x) : put_float(bytes, x, big);
    }
  for (const auto& list : lists) {
    put_int(static_cast<int>(list.size()));
    for (const int v : list) put_int(v);
  }
  return bytes;
}

INSTANTIATE_TEST_SUITE_P(
    Strips, CubeFormat,
    testing::Values(CubeFile{"strips.ply", "PLY (ASCII)", strip_ply("ascii", false)},
                    CubeFile{"lists.ply", "PLY (ASCII)", strip_ply("ascii", true)},
                    CubeFile{"little.ply", "PLY (little-endian)", strip_ply("binary_little_endian", false)},
                    CubeFile{"big.ply", "PLY (big-endian)", strip_ply("binary_big_endian", true)}));

INSTANTIATE_TEST_SUITE_P(
    All, CubeFormat,
    testing::Values(CubeFile{"cube.stl", "STL (binary)", stl(cube(100))},
                    CubeFile{"solid.stl", "STL (binary)", solid_binary()},
                    CubeFile{"trailing.stl", "STL (binary)", trailing_binary()},
                    CubeFile{"scan", "STL (ASCII)", stl_ascii(cube(100))},
                    CubeFile{"long.stl", "STL (ASCII)", long_name_ascii()},
                    CubeFile{"crlf.stl", "STL (ASCII)", with_crlf(stl_ascii(cube(100)))},
                    CubeFile{"scan", "OBJ", obj(cube(100))}, CubeFile{"quads.obj", "OBJ", quad_obj()},
                    CubeFile{"crlf.obj", "OBJ", with_crlf(quad_obj())},
                    CubeFile{"scan", "PLY (ASCII)", ply_ascii(cube(100))},
                    CubeFile{"quads.ply", "PLY (ASCII)", quad_ply()},
                    CubeFile{"little.ply", "PLY (little-endian)", ply_binary(cube(100), false)},
                    CubeFile{"big.ply", "PLY (big-endian)", ply_binary(cube(100), true)},
                    CubeFile{"scan", "OFF", off(cube(100))}, CubeFile{"quads.off", "OFF", quad_off()},
                    CubeFile{"cube.glb", "GLB", glb(cube(100))},
                    CubeFile{"scaled.glb", "GLB", glb(cube(50), "\"scale\":[2,2,2],")},
                    CubeFile{"nodes.glb", "GLB", plain_glb()}, CubeFile{"strips.glb", "GLB", strips_glb()}));

TEST(ScanFormats, NodesTurnAndShift) {
  // A quarter turn about x takes y to z; the matrix form is by columns.
  const auto turned = read(
      glb(cube(100), "\"rotation\":[0.7071067811865476,0,0,0.7071067811865476],\"translation\":[0,0,7],"),
      "a.glb");
  ASSERT_TRUE(turned) << turned.error().text();
  EXPECT_NEAR((bounds(turned->mesh).low - Eigen::Vector3d(0, -100, 7)).norm(), 0, 1e-4);
  const auto matrix = read(glb(cube(100), "\"matrix\":[1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,0,7,1],"), "a.glb");
  ASSERT_TRUE(matrix) << matrix.error().text();
  EXPECT_NEAR((bounds(matrix->mesh).low - Eigen::Vector3d(0, -100, 7)).norm(), 0, 1e-4);
}

TEST(ScanFormats, AFaceWithThousandsOfCorners) {
  std::string text, face = "f";
  constexpr int n = 5000;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    text += std::string("v ") + number(50 * std::cos(a)) + " " + number(50 * std::sin(a)) + " 0\n";
    face.append(" ").append(std::to_string(i + 1));
  }
  const auto scan = read(text_bytes(text + face), "disc.obj");
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->mesh.triangles.size(), n - 2u);
  double area = 0;
  for (const auto& t : scan->mesh.triangles) area += area_vector(scan->mesh, t).z();
  EXPECT_NEAR(area, std::numbers::pi * 2500, 0.01);
}

struct Lie {
  const char* name;
  FileBytes bytes;
  Code code;
  const char* says;
};
void PrintTo(const Lie& lie, std::ostream* out) { *out << lie.name << ": " << lie.says; }

class HostileScan : public testing::TestWithParam<Lie> {};

TEST_P(HostileScan, IsRefusedWithItsReason) {
  const auto mold = make_mold(GetParam().bytes, GetParam().name, {}, Context());
  ASSERT_FALSE(mold);
  EXPECT_EQ(meaning(mold.error().code).slug, meaning(GetParam().code).slug) << mold.error().text();
  EXPECT_NE(mold.error().text().find(GetParam().says), std::string::npos) << mold.error().text();
  EXPECT_NE(mold.error().where.find(GetParam().name), std::string::npos) << mold.error().text();
  EXPECT_FALSE(mold.error().fix.empty()) << mold.error().text();
}

FileBytes stl_that_claims(std::uint32_t count, std::size_t size) {
  FileBytes bytes(size, 0);
  for (int i = 0; i < 4; ++i)
    bytes[80 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(count >> 8 * i);
  return bytes;
}
FileBytes cut_short(FileBytes bytes, std::size_t by) {
  bytes.resize(bytes.size() - by);
  return bytes;
}
FileBytes with_float(FileBytes bytes, std::size_t at, std::uint32_t bits) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(bits >> 8 * i);
  return bytes;
}
// What reading as UTF-8 text with replacement marks, and writing back, does to a file.
FileBytes as_if_text(const FileBytes& bytes) {
  FileBytes out;
  for (const auto c : bytes) {
    if (c < 0x80)
      out.push_back(c);
    else
      out.insert(out.end(), {0xEF, 0xBF, 0xBD});
  }
  return out;
}
FileBytes as_if_latin(const FileBytes& bytes) {
  FileBytes out;
  for (const auto c : bytes) {
    if (c < 0x80)
      out.push_back(c);
    else
      out.insert(out.end(),
                 {static_cast<std::uint8_t>(0xC0 | c >> 6), static_cast<std::uint8_t>(0x80 | (c & 0x3F))});
  }
  return out;
}
FileBytes many_feeds_glb() {  // its positions are full of line feeds, which become CR LF
  auto mesh = sphere(100, 8);
  for (auto& p : mesh.vertices) p.x() = std::bit_cast<float>(0x420A0A0Au);
  return with_crlf(glb(mesh));
}
FileBytes ply(const std::string& elements, const std::string& data = "") {
  return text_bytes("ply\nformat ascii 1.0\n" + elements + "end_header\n" + data);
}
const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
FileBytes little_ply(const std::string& elements, const std::string& data = "") {
  return text_bytes("ply\nformat binary_little_endian 1.0\n" + elements + "end_header\n" + data);
}
FileBytes glb_with(const std::string& what, const std::string& by) {
  auto bytes = glb(cube(100));
  std::string text(bytes.begin() + 20, bytes.end());
  const auto json_size = text.find("]}") == text.npos ? 0 : text.rfind("}]}") + 3;
  std::string json = text.substr(0, json_size);
  const auto at = json.find(what);
  EXPECT_NE(at, json.npos) << what;
  json.replace(at, what.size(), by);
  return glb(json, FileBytes(96 + 72, 0));
}

INSTANTIATE_TEST_SUITE_P(Any, HostileScan,
                         testing::Values(Lie{"empty.stl", {}, Code::corrupt_file, "is empty"},
                                         Lie{"noise.bin", text_bytes("\x01\x02\x03 nothing"),
                                             Code::unsupported_format, "give STL, OBJ, PLY, OFF or GLB"},
                                         Lie{"scan.3mf", text_bytes("PK\x03\x04 archive"),
                                             Code::unsupported_format, "ZIP archive (3MF"},
                                         Lie{"scan.zip", text_bytes("PK\x03\x04 archive"), Code::corrupt_file,
                                             "the zip cannot be opened"},
                                         Lie{"scan.gltf", text_bytes("{\"asset\":{\"version\":\"2.0\"}}"),
                                             Code::unsupported_format, "glTF file in text form"},
                                         Lie{"photo.stl", text_bytes("\x89PNG\r\n\x1a\n"),
                                             Code::unsupported_format, "a picture"}));

INSTANTIATE_TEST_SUITE_P(
    Stl, HostileScan,
    testing::Values(
        // 84 + 50 * 85899346 wraps to 88 in 32 bits.
        Lie{"wraps.stl", stl_that_claims(85'899'346, 88), Code::corrupt_file,
            "85899346 triangles, which take 4294967384 bytes, but it has 88"},
        Lie{"most.stl", stl_that_claims(0xFFFFFFFF, 84), Code::corrupt_file, "4294967295 triangles"},
        Lie{"none.stl", stl_that_claims(0, 84), Code::unusable_scan, "no triangles"},
        Lie{"header.stl", FileBytes(50, 0), Code::corrupt_file, "within its header"},
        Lie{"short.stl", cut_short(stl(cube(100)), 1), Code::corrupt_file, "but it has 683 bytes"},
        Lie{"nan.stl", with_float(stl(cube(100)), 96, 0x7FC00000), Code::corrupt_file, "not a finite number"},
        Lie{"inf.stl", with_float(stl(cube(100)), 100, 0xFF800000), Code::corrupt_file,
            "not a finite number"},
        Lie{"far.stl", with_float(stl(cube(100)), 104, 0x7149F2CA), Code::corrupt_file, "implausible"},
        Lie{"text.stl", as_if_text(stl(sphere(100, 16))), Code::corrupt_file, "U+FFFD"},
        Lie{"latin.stl", as_if_latin(stl(sphere(100, 16))), Code::corrupt_file, "Latin-1 into UTF-8"},
        Lie{"words.stl", text_bytes("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n"),
            Code::corrupt_file, "words.stl, line 4"},
        Lie{"four.stl",
            text_bytes("solid a\nfacet\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 1 1 1\n"),
            Code::corrupt_file, "facet of three"},
        Lie{"two.stl", text_bytes("solid a\nfacet\nvertex 0 0 0\nvertex 0 0 0\nendfacet\n"),
            Code::corrupt_file, "does not have three vertices"},
        Lie{"ends.stl", text_bytes("solid a\nfacet\nvertex 0 0 0\n"), Code::corrupt_file,
            "ends within a facet"},
        Lie{"nothing.stl", text_bytes("solid a\nendsolid a\n"), Code::unusable_scan, "no triangles"},
        Lie{"flat.stl", stl(scaled(cube(100), 0)), Code::unusable_scan, "without area"}));

INSTANTIATE_TEST_SUITE_P(
    Obj, HostileScan,
    testing::Values(
        Lie{"range.obj", text_bytes("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), Code::corrupt_file,
            "names vertex 4, but the file has 3 (range.obj, line 4)"},
        Lie{"huge.obj", text_bytes("v 0 0 0\nf 1 1 99999999999999999999\n"), Code::corrupt_file,
            "not a corner of a face"},
        Lie{"large.obj", text_bytes("v 0 0 0\nf 1 1 9000000000\n"), Code::corrupt_file, "line 2"},
        Lie{"before.obj", text_bytes("v 0 0 0\nv 1 0 0\nf 1 2 -3\n"), Code::corrupt_file, "names vertex -3"},
        Lie{"zero.obj", text_bytes("v 0 0 0\nf 0 1 1\n"), Code::corrupt_file, "\"0\" is not a corner"},
        Lie{"two.obj", text_bytes("v 0 0\n"), Code::corrupt_file, "three numbers"},
        Lie{"nan.obj", text_bytes("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Code::corrupt_file,
            "not a finite number"},
        Lie{"big.obj", text_bytes("v 0 0 1e999\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Code::corrupt_file,
            "not a finite number"},
        Lie{"comma.obj", text_bytes("v 0,5 0 1\n"), Code::corrupt_file, "three numbers"},
        Lie{"points.obj", text_bytes("v 0 0 1\nv 1 1 1\n"), Code::unusable_scan, "point cloud"}));

INSTANTIATE_TEST_SUITE_P(
    Ply, HostileScan,
    testing::Values(
        Lie{"count.ply", ply("element vertex 4000000000\n" + xyz, "0 0 0\n"), Code::corrupt_file,
            "4000000000 of element \"vertex\", but only 6 bytes"},
        Lie{"count.ply", little_ply("element vertex 9223372036854775807\n" + xyz), Code::corrupt_file,
            "but only 0 bytes"},
        Lie{"minus.ply", ply("element vertex -1\n"), Code::corrupt_file, "does not say how many"},
        Lie{"list.ply",
            little_ply("element vertex 1\n" + xyz + "element face 1\nproperty list uint int vertex_indices\n",
                       std::string(12, '\0') + "\xff\xff\xff\x7f" + std::string(40, '\0')),
            Code::corrupt_file, "longer than the file (list.ply, face 0)"},
        Lie{"negative.ply",
            little_ply("element vertex 1\n" + xyz + "element face 1\nproperty list char int vertex_indices\n",
                       std::string(12, '\0') + "\xff" + std::string(40, '\0')),
            Code::corrupt_file, "longer than the file"},
        Lie{"float.ply", little_ply("element face 1\nproperty list float int vertex_indices\n"),
            Code::corrupt_file, "is not an integer"},
        Lie{"type.ply", ply("element vertex 1\nproperty quaternion x\n"), Code::corrupt_file,
            "unknown PLY property type \"quaternion\""},
        Lie{"axes.ply", ply("element vertex 1\nproperty float x\nproperty float y\n", "0 0\n"),
            Code::corrupt_file, "do not have x, y and z"},
        Lie{"early.ply", ply("property float x\n"), Code::corrupt_file, "before any element"},
        Lie{"range.ply",
            ply("element vertex 1\n" + xyz + "element face 1\nproperty list uchar int vertex_indices\n",
                "0 0 0\n3 0 0 7\n"),
            Code::corrupt_file, "names vertex 7, but the PLY file has 1 vertices"},
        Lie{"strip.ply",
            ply("element vertex 1\n" + xyz + "element tristrips 1\nproperty list int int vertex_indices\n",
                "0 0 0\n3 0 -2 0\n"),
            Code::corrupt_file, "does not exist (strip.ply, tristrips 0)"},
        Lie{"below.ply",
            ply("element vertex 1\n" + xyz + "element face 1\nproperty list uchar int vertex_indices\n",
                "0 0 0\n3 0 0 -1\n"),
            Code::corrupt_file, "does not exist (below.ply, face 0)"},
        Lie{"word.ply", ply("element vertex 2\n" + xyz, "0 0 0\n0 zero 0\n"), Code::corrupt_file,
            "not a number (word.ply, vertex 1)"},
        Lie{"header.ply", text_bytes("ply\nformat ascii 1.0\n"), Code::corrupt_file, "no end_header"},
        Lie{"format.ply", text_bytes("ply\nformat binary_middle_endian 1.0\n"), Code::corrupt_file,
            "binary_middle_endian"},
        Lie{"cloud.ply", ply("element vertex 1\n" + xyz, "0 0 0\n"), Code::unusable_scan, "point cloud"},
        Lie{"idle.ply", ply("element nothing 9000000000000000000\n"), Code::unusable_scan, "no triangles"}));

INSTANTIATE_TEST_SUITE_P(
    Off, HostileScan,
    testing::Values(Lie{"count.off", text_bytes("OFF\n999999999 1 0\n0 0 0\n"), Code::corrupt_file,
                        "999999999 vertices and 1 faces, but only 6 bytes"},
                    Lie{"range.off", text_bytes("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
                        Code::corrupt_file, "names vertex 3, but the vertices are 0 to 2"},
                    Lie{"short.off", text_bytes("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n"),
                        Code::corrupt_file, "fewer corners than it says (short.off, line 6)"},
                    Lie{"ends.off", text_bytes("OFF\n3 1 0\n0 0 0\n1 0 0                   \n"),
                        Code::corrupt_file, "ends after 2 of 3 vertices"},
                    Lie{"four.off", text_bytes("4OFF\n1 1 1\n"), Code::unsupported_format,
                        "another dimension"},
                    Lie{"binary.off", text_bytes("OFF BINARY\n"), Code::unsupported_format, "binary OFF"}));

INSTANTIATE_TEST_SUITE_P(
    Glb, HostileScan,
    testing::Values(
        Lie{"meshopt.glb", glb(cube(100), "", "\"extensionsRequired\":[\"EXT_meshopt_compression\"],"),
            Code::unsupported_format, "requires the extension EXT_meshopt_compression"},
        Lie{"quantized.glb", glb(cube(100), "", "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"),
            Code::unsupported_format, "KHR_mesh_quantization"},
        Lie{"header.glb", text_bytes("glTF\x02"), Code::corrupt_file, "within its header"},
        Lie{"short.glb", cut_short(glb(cube(100)), 4), Code::corrupt_file, "but it has"},
        Lie{"json.glb", glb("{\"asset\":", {}), Code::corrupt_file,
            "JSON chunk of the GLB file is not valid"},
        Lie{"deep.glb", glb("{\"a\":" + std::string(100'000, '['), {}), Code::corrupt_file, "not valid"},
        Lie{"nodes.glb", glb("{\"asset\":{}}", {}), Code::corrupt_file, "no nodes"},
        Lie{"cycle.glb",
            glb("{\"nodes\":[{\"children\":[1]},{\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}]}", {}),
            Code::corrupt_file, "do not form a tree"},
        Lie{"count.glb", glb_with("\"count\":8", "\"count\":9"), Code::corrupt_file,
            "accessor 0 of the GLB file has 9 elements, more than"},
        Lie{"most.glb", glb_with("\"count\":8", "\"count\":9007199254740991"), Code::corrupt_file,
            "more than its buffer view holds"},
        Lie{"offset.glb", glb_with("\"byteOffset\":96", "\"byteOffset\":9007199254740000"),
            Code::corrupt_file, "ends beyond"},
        Lie{"length.glb", glb_with("\"byteLength\":72", "\"byteLength\":73"), Code::corrupt_file,
            "ends beyond"},
        Lie{"minus.glb", glb_with("\"count\":36", "\"count\":-36"), Code::corrupt_file, "lacks its count"},
        Lie{"view.glb", glb_with("\"bufferView\":1", "\"bufferView\":7"), Code::corrupt_file,
            "no buffer view"},
        Lie{"sparse.glb", glb_with("\"count\":8", "\"sparse\":{},\"count\":8"), Code::unsupported_format,
            "sparse"},
        Lie{"outside.glb", glb_with("\"buffers\":[{", "\"buffers\":[{\"uri\":\"http://example.org/a.bin\","),
            Code::unsupported_format, "outside of it"},
        Lie{"bytes.glb", glb_with("\"componentType\":5126", "\"componentType\":5121"),
            Code::unsupported_format, "not floats"},
        Lie{"text.glb", as_if_text(glb(sphere(100, 16))), Code::corrupt_file, "U+FFFD"},
        Lie{"crlf.glb", many_feeds_glb(), Code::corrupt_file, "every line feed of the file became CR LF"}));

TEST(ScanFormats, AGlbThatIsAllJsonIsRefusedUnparsed) {
  const auto scan = read(glb(std::string((16u << 20) + 1, ' '), {}), "json.glb");
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().code, Code::too_large);
}

TEST(ScanFormats, AnIndexBeyondTheVerticesOfAGlb) {
  auto mesh = cube(100);
  mesh.triangles[5][2] = 8;
  const auto scan = read(glb(mesh), "index.glb");
  ASSERT_FALSE(scan);
  EXPECT_NE(scan.error().text().find("beyond the 8 of its mesh"), std::string::npos) << scan.error().text();
}

// Every prefix of a good file and every single damaged byte is read or refused, never anything else.
TEST(ScanFormats, NoDamageIsFatal) {
  for (const auto& file : {stl(cube(100)), stl_ascii(cube(100)), quad_obj(), quad_ply(),
                           ply_binary(cube(100), true), quad_off(), strips_glb()}) {
    for (std::size_t size = 0; size < file.size(); size += 7)
      read(FileBytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)), "a.stl");
    for (std::size_t at = 0; at < file.size(); ++at)
      for (const std::uint8_t flip : {0x01, 0x80, 0xFF}) {
        auto damaged = file;
        damaged[at] ^= flip;
        const auto scan = read(damaged, "a.obj");
        if (!scan) {
          EXPECT_FALSE(scan.error().what.empty());
        } else {
          for (const auto& t : scan->mesh.triangles)
            for (const int v : t) ASSERT_TRUE(v >= 0 && v < static_cast<int>(scan->mesh.vertices.size()));
        }
      }
  }
}

}  // namespace
}  // namespace vacuform::scan_formats_test
