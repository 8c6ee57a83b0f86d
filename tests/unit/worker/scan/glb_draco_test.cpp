// GLB files whose meshes are compressed by Draco.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform::glb_draco_test {
namespace {

using shapes::FileBytes;

// A cube with the corner of each triangle as its texture coordinates, and a colour for each vertex.
FileBytes compressed_cube(draco::MeshEncoderMethod method, bool with_metadata = false) {
  const TriangleMesh mesh = shapes::cube(100);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(mesh.triangles.size()));
  const int places = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const int colours = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Eigen::Vector3f, 3> corners;
    std::array<std::array<std::uint8_t, 4>, 3> colour;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])].cast<float>();
      colour[k] = {static_cast<std::uint8_t>(corners[k].x() > 50 ? 255 : 51), 0, 0, 255};
    }
    const Eigen::Vector2f at[] = {{0, 0}, {1, 0}, {0, 1}};
    const draco::FaceIndex face(static_cast<std::uint32_t>(t));
    builder.SetAttributeValuesForFace(places, face, corners[0].data(), corners[1].data(), corners[2].data());
    builder.SetAttributeValuesForFace(uv, face, at[0].data(), at[1].data(), at[2].data());
    builder.SetAttributeValuesForFace(colours, face, colour[0].data(), colour[1].data(), colour[2].data());
  }
  const auto built = builder.Finalize();
  if (with_metadata) built->AddMetadata(std::make_unique<draco::GeometryMetadata>());
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*built, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

std::string accessor(const char* type, int component) {
  return std::string(R"({"type":")") + type + R"(","componentType":)" + std::to_string(component) +
         R"(,"count":36})";
}

FileBytes glb_of(const FileBytes& compressed, const std::string& view = "0") {
  const std::string size = std::to_string(compressed.size());
  return shapes::glb(
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"material":0,"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},"indices":3,)"
      R"("extensions":{"KHR_draco_mesh_compression":{"bufferView":)" +
          view + R"(,"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2}}}}]}],)" +
          R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],)" +
          R"("images":[{"bufferView":0}],"accessors":[)" + accessor("VEC3", 5126) + "," +
          accessor("VEC2", 5126) + "," + accessor("VEC4", 5121) + "," + accessor("SCALAR", 5123) +
          R"(],"bufferViews":[{"buffer":0,"byteLength":)" + size + R"(}],"buffers":[{"byteLength":)" + size +
          "}]}",
      compressed);
}

Result<ScanFile> read(const FileBytes& bytes) {
  const Context context;
  return read_scan(bytes, "a.glb", ScanProgress(context), ScanParts::with_colours);
}

class CompressedGlb : public testing::TestWithParam<draco::MeshEncoderMethod> {};

TEST_P(CompressedGlb, HasTheTrianglesAndColoursOfTheMesh) {
  const auto scan = read(glb_of(compressed_cube(GetParam())));
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_EQ(scan->mesh.triangles.size(), 12u);
  ASSERT_TRUE(scan->colours);
  ASSERT_EQ(scan->colours->uv.size(), 12u);
  ASSERT_EQ(scan->colours->vertex.size(), scan->mesh.vertices.size());
  double volume = 0;
  for (std::size_t t = 0; t < 12; ++t) {
    std::array<Eigen::Vector3d, 3> p;
    Eigen::Vector2f sum(0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(scan->mesh.triangles[t][k]);
      p[k] = scan->mesh.vertices[v];
      EXPECT_NEAR(scan->colours->vertex[v].x(), p[k].x() > 50 ? 1 : 0.2, 1e-6);
      sum += scan->colours->uv[t][k];
    }
    EXPECT_LT((sum - Eigen::Vector2f(1, 1)).norm(), 1e-4f);
    volume += p[0].dot(p[1].cross(p[2])) / 6;
  }
  EXPECT_NEAR(volume, 1e6, 1);  // mm^3, and the triangles face outwards
}

TEST_P(CompressedGlb, IsRefusedWhereverItIsCut) {
  const FileBytes whole = compressed_cube(GetParam());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto scan = read(glb_of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}));
    EXPECT_FALSE(scan) << size;
  }
}

TEST_P(CompressedGlb, IsRefusedWithMetadataWhichMayNamePeople) {
  const auto scan = read(glb_of(compressed_cube(GetParam(), true)));
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().code, Code::unsupported_format);
  EXPECT_NE(scan.error().text().find("carries metadata"), std::string::npos) << scan.error().text();
}

TEST_P(CompressedGlb, IsRefusedBeforeItTakesMemoryForTrianglesThatItClaims) {
  FileBytes bytes = compressed_cube(GetParam());
  bytes.resize(GetParam() == draco::MESH_EDGEBREAKER_ENCODING
                   ? 13
                   : 11);  // up to the numbers, of which triangles are the second or the first
  if (GetParam() == draco::MESH_EDGEBREAKER_ENCODING) bytes.back() = 8;
  for (const int byte : {0xff, 0xff, 0xff, 0xff, 0x0f}) bytes.push_back(static_cast<std::uint8_t>(byte));
  bytes.resize(100);
  const auto scan = read(glb_of(bytes));
  ASSERT_FALSE(scan);
  EXPECT_EQ(scan.error().code, Code::too_large) << scan.error().text();
}

INSTANTIATE_TEST_SUITE_P(, CompressedGlb,
                         testing::Values(draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING),
                         [](const auto& method) {
                           return method.param == draco::MESH_SEQUENTIAL_ENCODING ? "Sequential"
                                                                                  : "Edgebreaker";
                         });

TEST(CompressedGlbFile, IsRefusedWhenItIsNoDraco) {
  const auto noise = read(glb_of(FileBytes(200, 7)));
  ASSERT_FALSE(noise);
  EXPECT_NE(noise.error().text().find("does not begin as Draco does"), std::string::npos);
  FileBytes old = compressed_cube(draco::MESH_EDGEBREAKER_ENCODING);
  old[6] = 1;
  EXPECT_EQ(read(glb_of(old)).error().code, Code::unsupported_format);
  EXPECT_EQ(read(glb_of(old, "9")).error().code, Code::corrupt_file);
}

}  // namespace
}  // namespace vacuform::glb_draco_test
