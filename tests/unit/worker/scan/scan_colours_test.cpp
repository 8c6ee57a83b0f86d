// The colours that scan files give their triangles, and the ways in which such files lie.
#include "worker/scan/scan_colours.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fixtures/coloured_scans.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform::scan_colours_test {
namespace {

using coloured::GlbParts;
using coloured::Model;
using shapes::FileBytes;
using shapes::text_bytes;

Result<ScanFile> read_colours(const FileBytes& bytes, const std::string& name) {
  const Context context;
  return read_scan(bytes, name, ScanProgress(context), ScanParts::with_colours);
}

Model one_triangle() {
  return {{{0, 0, 0}, {100, 0, 0}, {0, 100, 0}}, {{0.25, 0.5}, {0.75, 0.5}, {0.25, 1}}, {}};
}
const FileBytes some_image = text_bytes("not looked into");

TEST(ScanColours, AreEncodedInBytesAsInFloats) {
  const auto expect_same = [](float linear) {
    EXPECT_EQ(srgb_byte(linear), std::lround(255 * srgb_from_linear(linear))) << linear;
  };
  for (const float outside : {-1.0f, 2.0f}) expect_same(outside);
  for (int i = 0; i <= 1'000'000; ++i) expect_same(1e-6f * static_cast<float>(i));
  for (int k = 0; k < 255; ++k) {  // on both sides of the border of two bytes
    float border = linear_from_srgb((static_cast<float>(k) + 0.5f) / 255);
    for (int i = 0; i < 20; ++i) border = std::nextafter(border, 0.0f);
    for (int i = 0; i < 40; ++i, border = std::nextafter(border, 1.0f)) expect_same(border);
  }
}

TEST(ScanColours, AreTiedToTheTrianglesOfAGlb) {
  const auto scan = read_colours(coloured::glb(one_triangle(), some_image), "a.glb");
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_TRUE(scan->colours);
  const ScanColours& colours = *scan->colours;
  ASSERT_EQ(colours.images.size(), 1u);
  EXPECT_EQ(colours.images[0].bytes, some_image);
  EXPECT_EQ(colours.material, std::vector<int>{0});
  EXPECT_EQ(colours.materials[0].image, 0);
  EXPECT_EQ(colours.materials[0].across, Wrap::repeat);
  ASSERT_EQ(colours.uv.size(), 1u);
  EXPECT_EQ(colours.uv[0][1], Eigen::Vector2f(0.75f, 0.5f));
  EXPECT_TRUE(colours.vertex.empty());
}

TEST(ScanColours, FollowTheTextureTransformOfAGlb) {
  GlbParts parts;
  parts.uv_name = "TEXCOORD_3";
  parts.material =
      R"("pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"baseColorTexture":{"index":0,"texCoord":1,
         "extensions":{"KHR_texture_transform":{"offset":[0.5,0],"rotation":1.5707963267948966,"scale":[2,4],
         "texCoord":3}}}})";
  parts.texture = R"("source":0,"sampler":0)";
  parts.samplers = R"("samplers":[{"wrapS":33071,"wrapT":33648}],)";
  const auto scan = read_colours(coloured::glb(one_triangle(), some_image, parts), "a.glb");
  ASSERT_TRUE(scan) << scan.error().text();
  // (0.75, 0.5) is scaled to (1.5, 2) and turned counter-clockwise, as one sees it with v down, to (2, -1.5).
  EXPECT_LT((scan->colours->uv[0][1] - Eigen::Vector2f(2.5f, -1.5f)).norm(), 1e-6f);
  EXPECT_EQ(scan->colours->materials[0].factor, Eigen::Vector3f(0.5f, 0.25f, 1));
  EXPECT_EQ(scan->colours->materials[0].across, Wrap::clamp);
  EXPECT_EQ(scan->colours->materials[0].down, Wrap::mirror);
}

TEST(ScanColours, TakeVerticesAsLinearInGlbAndEncodedInPlyAndObj) {
  Model model = one_triangle();
  model.uv.clear();
  model.colours = {{1, 0, 0}, {0, 0.5f, 0}, {0.2f, 0.2f, 0.2f}};
  for (const auto& [name, bytes] : {std::pair<std::string, FileBytes>{"a.glb", coloured::glb(model, {})},
                                    {"a.ply", coloured::ply(model)},
                                    {"a.obj", coloured::obj(model)}}) {
    const auto scan = read_colours(bytes, name);
    ASSERT_TRUE(scan) << scan.error().text();
    ASSERT_TRUE(scan->colours) << name;
    ASSERT_EQ(scan->colours->vertex.size(), 3u) << name;
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LT((scan->colours->vertex[i] - model.colours[i]).norm(), 0.005f) << name << " " << i;
  }
}

TEST(ScanColours, ReadAnObjThatCountsTo255) {
  const auto scan = read_colours(text_bytes("v 0 0 0 255 0 0\nv 9 0 0 0 255 0\nv 0 9 0\nf 1 2 3\n"), "a.obj");
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->colours->vertex[0], Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(scan->colours->vertex[2], Eigen::Vector3f(1, 1, 1));  // has none
}

TEST(ScanColours, OfAZippedObjFollowItsMaterials) {
  const auto scan = read_colours(
      coloured::obj_zip(
          one_triangle(), some_image,
          "newmtl m2\nKd 0 0 0\nnewmtl m1\nKd 1 0.5 0\nmap_Kd -s 2 4 1 -o 0.5 0 -clamp on texture-1\n"),
      "a.zip");
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->format, "OBJ, zipped");
  ASSERT_TRUE(scan->colours);
  const ScanColours& colours = *scan->colours;
  ASSERT_EQ(colours.images.size(), 1u);
  EXPECT_EQ(colours.images[0].bytes, some_image);
  const ScanMaterial& material = colours.materials[static_cast<std::size_t>(colours.material[0])];
  EXPECT_EQ(material.image, 0);
  EXPECT_EQ(material.across, Wrap::clamp);
  EXPECT_LT((material.factor - Eigen::Vector3f(1, linear_from_srgb(0.5f), 0)).norm(), 1e-6f);
  // (0.75, 0.5 from below) is scaled to (1.5, 2) and moved to (2, 2 from below).
  EXPECT_LT((colours.uv[0][1] - Eigen::Vector2f(2, -1)).norm(), 1e-6f);
}

TEST(ScanColours, OfAnObjWithoutTextureCoordinatesAreThoseOfTheMaterial) {
  const auto scan =
      read_colours(coloured::zipped("model.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nusemtl m1\nf 1 2 3\n",
                                    "newmtl m1\nKd 0 1 0\nmap_Kd texture-1\n", some_image),
                   "a.zip");
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_TRUE(scan->colours);
  const ScanMaterial& shown = scan->colours->materials[static_cast<std::size_t>(scan->colours->material[0])];
  EXPECT_EQ(shown.image, -1);
  EXPECT_EQ(shown.factor, Eigen::Vector3f(0, 1, 0));
}

TEST(ScanColours, OfAZippedPlyAreOfCornersOrOfVertices) {
  for (const bool of_corners : {true, false}) {
    const auto scan = read_colours(coloured::ply_zip(one_triangle(), some_image, of_corners), "a.zip");
    ASSERT_TRUE(scan) << scan.error().text();
    EXPECT_EQ(scan->format, "PLY (ASCII), zipped");
    ASSERT_TRUE(scan->colours);
    EXPECT_EQ(scan->colours->images[0].bytes, some_image);
    EXPECT_EQ(scan->colours->materials[static_cast<std::size_t>(scan->colours->material[0])].image, 0);
    EXPECT_LT((scan->colours->uv[0][2] - Eigen::Vector2f(0.25f, 1)).norm(), 1e-6f) << of_corners;
  }
}

TEST(ScanColours, AreMissingWhereAFileHasNone) {
  const auto cube = shapes::cube(100);
  for (const auto& [name, bytes] : {std::pair<std::string, FileBytes>{"a.stl", shapes::stl(cube)},
                                    {"a.obj", shapes::obj(cube)},
                                    {"a.ply", shapes::ply_ascii(cube)},
                                    {"a.glb", shapes::glb(cube)}}) {
    const auto scan = read_colours(bytes, name);
    ASSERT_TRUE(scan) << scan.error().text();
    EXPECT_FALSE(scan->colours) << name;
  }
}

struct ColourLie {
  const char* name;
  FileBytes bytes;
  Code code;
  const char* what;  // part of the message
};
void PrintTo(const ColourLie& lie, std::ostream* out) { *out << lie.what; }

FileBytes lying_glb(const std::function<void(GlbParts&)>& change) {
  GlbParts parts;
  change(parts);
  return coloured::glb(one_triangle(), some_image, parts);
}
FileBytes far_uv_glb(double u) {
  Model model = one_triangle();
  model.uv[0].x() = u;
  return coloured::glb(model, some_image);
}

class LyingColours : public testing::TestWithParam<ColourLie> {};

TEST_P(LyingColours, AreNamedAndLeaveTheShapeReadable) {
  const auto scan = read_colours(GetParam().bytes, GetParam().name);
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().code, GetParam().code) << scan.error().text();
  EXPECT_NE(scan.error().text().find(GetParam().what), std::string::npos) << scan.error().text();
  const Context context;
  EXPECT_TRUE(read_scan(GetParam().bytes, GetParam().name, ScanProgress(context)));
}

INSTANTIATE_TEST_SUITE_P(
    Scan, LyingColours,
    testing::Values(
        ColourLie{"a.glb", lying_glb([](GlbParts& p) { p.image = R"("bufferView":7)"; }), Code::corrupt_file,
                  "image 0 of the GLB file has no buffer view"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) { p.image = R"("uri":"../secret.png")"; }),
                  Code::unsupported_format, "image 0 of the GLB file lies outside of it"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) { p.texture = R"("source":5)"; }), Code::corrupt_file,
                  "no image 5"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) {
                    p.material = R"("pbrMetallicRoughness":{"baseColorTexture":{"index":-1}})";
                  }),
                  Code::corrupt_file, "not of the documented form"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) { p.uv_name = "TEXCOORD_1"; }), Code::corrupt_file,
                  "no TEXCOORD_0"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) {
                    p.texture = R"("extensions":{"KHR_texture_basisu":{"source":0}})";
                  }),
                  Code::unsupported_format, "KTX2"},
        ColourLie{"a.glb", lying_glb([](GlbParts& p) {
                    p.texture = R"("extensions":{"EXT_texture_webp":{"source":0}})";
                  }),
                  Code::unsupported_format, "WebP"},
        ColourLie{"a.glb", far_uv_glb(std::nan("")), Code::corrupt_file, "not a plausible number"},
        ColourLie{"a.glb", far_uv_glb(1e9), Code::corrupt_file, "not a plausible number"},
        ColourLie{"a.zip",
                  coloured::zipped("model.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nusemtl m1\nf 1 2 3\n",
                                   "newmtl m1\nmap_Kd texture-2\n", some_image),
                  Code::unusable_scan, "lacks an image that the model names"},
        ColourLie{
            "a.zip",
            coloured::zipped("model.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nvt 0 0\nusemtl m1\nf 1/1 2/1 3/7\n",
                             "newmtl m1\nmap_Kd texture-1\n", some_image),
            Code::corrupt_file, "a face names vt 7, but the file has 1"},
        ColourLie{"a.zip",
                  coloured::zipped("model.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nusemtl m1\nf 1 2 3\n",
                                   "newmtl m1\nKd red\n", some_image),
                  Code::corrupt_file, "MTL, line 2"},
        ColourLie{
            "a.ply",
            text_bytes("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                       "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                       "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                       "0 0 0 1 2 red\n9 0 0 1 2 3\n0 9 0 1 2 3\n3 0 1 2\n"),
            Code::corrupt_file, "vertex 0"}));

}  // namespace
}  // namespace vacuform::scan_colours_test
