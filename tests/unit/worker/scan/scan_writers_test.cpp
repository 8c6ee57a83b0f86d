// Files as careless programs write them: what they hold is read, or refused with the reason.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fixtures/coloured_scans.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/sides.hpp"
#include "worker/scan/upright.hpp"

namespace vacuform::scan_writers_test {
namespace {

using Eigen::Vector3d;
using shapes::FileBytes;
using shapes::text_bytes;

Result<ScanFile> read(const FileBytes& bytes, const std::string& name = "a.stl",
                      ScanParts parts = ScanParts::with_colours) {
  const Context context;
  return read_scan(bytes, name, ScanProgress(context), parts);
}

// Asymmetric, off the origin, and turned by an odd angle.
TriangleMesh odd_shape() {
  const Eigen::Affine3d by =
      Eigen::Translation3d(7.3, -21.9, 4.1) * Eigen::AngleAxisd(0.37, Vector3d(1, 2, 3).normalized());
  return shapes::moved(shapes::box({0, 0, 0}, {31.7, 52.3, 11.9}), by);
}

FileBytes with_count(FileBytes bytes, std::uint32_t count) {
  for (std::size_t i = 0; i < 4; ++i) bytes[80 + i] = static_cast<std::uint8_t>(count >> 8 * i);
  return bytes;
}
FileBytes behind(FileBytes first, const FileBytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}
FileBytes with_head(FileBytes bytes, const std::string& head) {
  std::fill_n(bytes.begin(), 80, std::uint8_t{0});
  std::copy(head.begin(), head.end(), bytes.begin());
  return bytes;
}
FileBytes in_upper_case(FileBytes text) {
  for (auto& c : text)
    if (c >= 'a' && c <= 'z' && c != 'e') c = static_cast<std::uint8_t>(c - 'a' + 'A');
  return text;
}
std::string replaced(const FileBytes& bytes, const std::string& what, const std::string& by) {
  std::string text(bytes.begin(), bytes.end());
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

TEST(ScanWriters, ABinaryStlIsReadByItsSize) {
  const FileBytes right = shapes::stl(odd_shape());
  const auto whole = read(right);
  ASSERT_TRUE(whole);
  EXPECT_TRUE(whole->notes.empty());
  for (const std::uint32_t count : {0u, 1u, 6u, 11u, 0xFFFFFFFFu}) {
    const auto scan = read(with_count(right, count));
    ASSERT_TRUE(scan) << count << " " << scan.error().text();
    EXPECT_EQ(scan->mesh.vertices, whole->mesh.vertices) << count;
    ASSERT_EQ(scan->notes.size(), 1u) << count;
    EXPECT_NE(scan->notes[0].find("the file has 12"), std::string::npos) << scan->notes[0];
  }
  EXPECT_FALSE(read(with_count(right, 13)));  // it is cut short
}

TEST(ScanWriters, AllBodiesOfABinaryStlAreRead) {
  const TriangleMesh a = odd_shape(), b = shapes::shifted(shapes::cube(9), 100, 3, 5);
  const auto scan = read(behind(behind(shapes::stl(a), shapes::stl(b)), shapes::stl(a)));
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->mesh.triangles.size(), 36u);
  EXPECT_NEAR(bounds(scan->mesh).high.x(), 109, 1e-4);
  ASSERT_EQ(scan->notes.size(), 1u);
  EXPECT_NE(scan->notes[0].find("3 bodies"), std::string::npos);
  // The first may be empty.
  const auto second = read(behind(with_count(FileBytes(84, 0), 0), shapes::stl(a)));
  ASSERT_TRUE(second) << second.error().text();
  EXPECT_EQ(second->mesh.triangles.size(), 12u);
}

TEST(ScanWriters, BytesBehindTheTrianglesOfAnStlAreIdleOrRefused) {
  const FileBytes right = shapes::stl(odd_shape());
  for (const FileBytes& rest :
       {FileBytes(100, 0), text_bytes(std::string(150, 'x')), text_bytes("made by us\n")}) {
    const auto scan = read(behind(right, rest));
    ASSERT_TRUE(scan) << scan.error().text();
    EXPECT_EQ(scan->mesh.triangles.size(), 12u);
  }
  for (const std::size_t size : {37u, 100u, 500u}) {
    const auto scan = read(behind(right, FileBytes(size, 0x7f)));
    ASSERT_FALSE(scan) << size;
    EXPECT_NE(scan.error().what.find(std::to_string(size) + " bytes follow"), std::string::npos)
        << scan.error().text();
  }
}

TEST(ScanWriters, KeywordsOfAnAsciiStlAreInAnyCase) {
  const FileBytes right = shapes::stl_ascii(odd_shape());
  const auto whole = read(right);
  ASSERT_TRUE(whole);
  const FileBytes mark = text_bytes("\xef\xbb\xbf");
  for (const FileBytes& bytes :
       {in_upper_case(right), text_bytes(replaced(right, "endsolid", "ENDSOLID")),
        text_bytes(replaced(right, "endsolid", "end solid")),
        text_bytes(replaced(right, "endloop", "end loop")),
        text_bytes(replaced(right, "endfacet", "End Facet")), text_bytes(replaced(right, "solid", "Solid")),
        behind(mark, right), behind(mark, in_upper_case(right))}) {
    const auto scan = read(bytes);
    ASSERT_TRUE(scan) << std::string(bytes.begin(), bytes.begin() + 60) << scan.error().text();
    EXPECT_EQ(scan->format, "STL (ASCII)");
    EXPECT_EQ(scan->mesh.vertices, whole->mesh.vertices);
  }
  const auto wide = read(text_bytes(std::string("\xff\xfes\0o\0l\0i\0d\0", 12)));
  ASSERT_FALSE(wide);
  EXPECT_NE(wide.error().what.find("UTF-16"), std::string::npos) << wide.error().text();
}

struct Named {
  const char* name;
  FileBytes lps, ras, none;
};
std::vector<Named> spaces() {
  const TriangleMesh mesh = odd_shape();
  const auto comment = [](const FileBytes& bytes, const std::string& before, const std::string& line) {
    return text_bytes(replaced(bytes, before, before + line));
  };
  const FileBytes ply = shapes::ply_ascii(mesh), ascii = shapes::stl_ascii(mesh), obj = shapes::obj(mesh);
  const std::string slicer = "3D Slicer output. SPACE=", format = "format ascii 1.0\n";
  return {{"a.stl", with_head(shapes::stl(mesh), slicer + "LPS"),
           with_head(shapes::stl(mesh), slicer + "RAS"), with_head(shapes::stl(mesh), "AEROSPACE=LPS")},
          {"ascii.stl", comment(ascii, "solid cube", " " + slicer + "LPS"),
           comment(ascii, "solid cube", " " + slicer + "RAS"), ascii},
          {"a.ply", comment(ply, format, "comment " + slicer + "LPS\n"),
           comment(ply, format, "comment " + slicer + "RAS\n"), ply},
          {"a.obj", behind(text_bytes("# " + slicer + "LPS\n"), obj),
           behind(text_bytes("# " + slicer + "RAS\n"), obj), obj}};
}

TEST(ScanWriters, NameTheAxesOfThePatient) {
  for (const Named& file : spaces()) {
    SCOPED_TRACE(file.name);
    for (const auto& [bytes, space] :
         {std::pair{file.lps, PatientSpace::lps}, std::pair{file.ras, PatientSpace::ras},
          std::pair{file.none, PatientSpace::unknown}}) {
      const auto scan = read(bytes, file.name);
      ASSERT_TRUE(scan) << scan.error().text();
      EXPECT_EQ(scan->space, space);
    }
  }
}

TEST(ScanWriters, AxesOfThePatientPlaceTheHead) {
  // A bump on one side, at the patient's left and front of the file.
  const auto head = [](double x, double y) {
    return shapes::joined(shapes::scaled(shapes::sphere(60), 1),
                          shapes::shifted(shapes::sphere(12), x, y, 40));
  };
  ScanSettings settings;
  settings.units = Unit::mm;
  for (const auto& [space, bytes] :
       {std::pair<std::string, FileBytes>{"LPS", with_head(shapes::stl(head(36, -48)), "SPACE=LPS")},
        std::pair<std::string, FileBytes>{"RAS", with_head(shapes::stl(head(-36, 48)), "SPACE=RAS")}}) {
    SCOPED_TRACE(space);
    const auto mold = make_mold(bytes, "a.stl", settings, Context());
    ASSERT_TRUE(mold) << mold.error().text();
    const bool lps = space == "LPS";
    EXPECT_EQ(mold->findings.up, UpAxis::plus_z);
    EXPECT_FALSE(mold->findings.up_guessed);
    EXPECT_EQ(mold->findings.front, lps ? FrontSide::minus_y : FrontSide::plus_y);
    EXPECT_TRUE(mold->findings.front_from_format);
    EXPECT_EQ(mold->findings.left_from_file, lps ? FrontSide::plus_x : FrontSide::minus_x);
    // The bump comes to the front and the left of the mold.
    const Vector3d bump = mold->placing(lps ? Vector3d(36, -48, 40) : Vector3d(-36, 48, 40)),
                   middle = mold->placing(Vector3d(0, 0, 40));
    EXPECT_NEAR((bump - middle).x(), -36, 1e-6);
    EXPECT_NEAR((bump - middle).y(), 48, 1e-6);
    EXPECT_TRUE(std::ranges::none_of(mold->warnings,
                                     [](const Warning& w) { return w.code == "space-contradicted"; }));
    const auto sides = side_warnings(mold->findings);
    ASSERT_EQ(sides.size(), 1u);
    EXPECT_NE(sides[0].text.find("SPACE=" + space), std::string::npos) << sides[0].text;
  }
}

TEST(ScanWriters, SettingsWinOverTheAxesOfTheFileWithAWarning) {
  const FileBytes bytes = with_head(shapes::stl(shapes::sphere(60)), "SPACE=LPS");
  const auto with = [&](const auto& change) {
    ScanSettings settings;
    settings.units = Unit::mm;
    change(settings);
    return make_mold(bytes, "a.stl", settings, Context());
  };
  const auto warning = [](const Result<Mold>& mold) {
    const auto found = std::ranges::find(mold->warnings, "space-contradicted", &Warning::code);
    return found == mold->warnings.end() ? std::string() : found->text;
  };
  const auto front = with([](ScanSettings& s) { s.front = FrontSide::plus_y; });
  ASSERT_TRUE(front);
  EXPECT_EQ(front->findings.front, FrontSide::plus_y);
  EXPECT_NE(warning(front).find("the face at +y and the patient's left at -x"), std::string::npos)
      << warning(front);
  const auto mirror = with([](ScanSettings& s) { s.mirror = Mirror::yes; });
  ASSERT_TRUE(mirror);
  EXPECT_NE(warning(mirror).find("not bring the patient's left at -x"), std::string::npos) << warning(mirror);
  const auto up = with([](ScanSettings& s) { s.up = UpAxis::plus_y; });
  ASSERT_TRUE(up);
  EXPECT_NE(warning(up).find("the crown up"), std::string::npos) << warning(up);
  const auto same = with([](ScanSettings& s) {
    s.front = FrontSide::minus_y;
    s.yaw_deg = 20;
  });
  ASSERT_TRUE(same);
  EXPECT_EQ(warning(same), "");
}

// A triangle whose positions are accessor 0, with other parts of the file.
struct GlbScene {
  std::string nodes, attributes = "", primitive = "", mesh = "", more = "";
  std::vector<std::string> accessors = {};  // of views from 1 on
  std::vector<FileBytes> views = {};
};
const Vector3d corners[] = {{1, 2, 3}, {5, 2.5, 3}, {1.5, 9, 4}};
FileBytes floats(const std::vector<double>& values) {
  FileBytes bytes;
  for (const double x : values) shapes::put_float(bytes, x);
  return bytes;
}
FileBytes glb_of(const GlbScene& scene) {
  FileBytes binary;
  for (const Vector3d& p : corners)
    for (int k = 0; k < 3; ++k) shapes::put_float(binary, p[k]);
  std::string views = R"({"buffer":0,"byteLength":36})",
              accessors = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    views += R"(,{"buffer":0,"byteOffset":)" + std::to_string(binary.size()) + R"(,"byteLength":)" +
             std::to_string(scene.views[i].size()) + "}";
    accessors += R"(,{"bufferView":)" + std::to_string(i + 1) + "," + scene.accessors[i] + "}";
    binary.insert(binary.end(), scene.views[i].begin(), scene.views[i].end());
    while (binary.size() % 4) binary.push_back(0);
  }
  return shapes::glb(R"({"asset":{"version":"2.0"},"scene":0,)" + scene.more + R"("nodes":[)" + scene.nodes +
                         R"(],"meshes":[{)" + scene.mesh + R"("primitives":[{)" + scene.primitive +
                         R"("attributes":{"POSITION":0)" + scene.attributes + R"(}}]}],"accessors":[)" +
                         accessors + R"(],"bufferViews":[)" + views + R"(],"buffers":[{"byteLength":)" +
                         std::to_string(binary.size()) + "}]}",
                     binary);
}
void expect_corners(const Result<ScanFile>& scan, const std::function<Vector3d(std::size_t)>& place) {
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_EQ(scan->mesh.vertices.size() % 3, 0u);
  for (std::size_t i = 0; i < scan->mesh.vertices.size(); ++i)
    EXPECT_LT((scan->mesh.vertices[i] - place(i)).norm(), 1e-5)
        << i << ": " << scan->mesh.vertices[i].transpose();
}

// Two joints: one at (10, 0, 0) and twice as large, one turned by a quarter about z below a node that is shifted.
GlbScene skinned() {
  GlbScene scene;
  scene.more = R"("scenes":[{"nodes":[0,1,2]}],"skins":[{"joints":[1,3],"inverseBindMatrices":3}],)";
  scene.nodes =
      R"({"mesh":0,"skin":0,"translation":[500,0,0],"scale":[3,3,3]},{"translation":[10,0,0],"scale":[2,2,2]},)"
      R"({"translation":[0,7,0],"children":[3]},{"rotation":[0,0,0.7071067811865476,0.7071067811865476]})";
  scene.attributes = R"(,"JOINTS_0":1,"WEIGHTS_0":2)";
  scene.accessors = {R"("componentType":5121,"count":3,"type":"VEC4")",
                     R"("componentType":5126,"count":3,"type":"VEC4")",
                     R"("componentType":5126,"count":2,"type":"MAT4")"};
  scene.views = {{0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0},
                 floats({1, 0, 0, 0, 1, 0, 0, 0, 0.25, 0.75, 0, 0}),
                 floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1,  // shifts by -1 in x
                         1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1})};
  return scene;
}

TEST(ScanWriters, ASkinHoldsTheVerticesOfAGlb) {
  const auto first = [](const Vector3d& p) -> Vector3d {
    return Vector3d(10, 0, 0) + 2 * (p - Vector3d(1, 0, 0));
  };
  const auto second = [](const Vector3d& p) { return Vector3d(-p.y(), p.x() + 7, p.z()); };
  expect_corners(read(glb_of(skinned()), "a.glb"), [&](std::size_t i) -> Vector3d {
    if (i == 0) return first(corners[0]);
    if (i == 1) return second(corners[1]);
    return 0.25 * first(corners[2]) + 0.75 * second(corners[2]);
  });
  GlbScene scene = skinned();
  scene.views[0][4] = 2;
  const auto beyond = read(glb_of(scene), "a.glb");
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().what.find("joint 2"), std::string::npos) << beyond.error().text();
  scene = skinned();
  scene.more = R"("scenes":[{"nodes":[0,1]}],"skins":[{"joints":[1,3],"inverseBindMatrices":3}],)";
  const auto outside = read(glb_of(scene), "a.glb");
  ASSERT_FALSE(outside);
  EXPECT_NE(outside.error().what.find("not a node of its scene"), std::string::npos)
      << outside.error().text();
}

TEST(ScanWriters, MorphTargetsInUseMoveTheVerticesOfAGlb) {
  GlbScene scene;
  scene.more = R"("scenes":[{"nodes":[0]}],)";
  scene.nodes = R"({"mesh":0,"scale":[2,2,2]})";
  scene.mesh = R"("weights":[0.5,0],)";
  scene.primitive = R"("targets":[{"POSITION":1},{"POSITION":99}],)";
  scene.accessors = {R"("componentType":5126,"count":3,"type":"VEC3")"};
  scene.views = {floats({1, 0, 0, 0, 2, 0, 0, 0, -4})};
  const Vector3d moves[] = {{1, 0, 0}, {0, 2, 0}, {0, 0, -4}};
  expect_corners(read(glb_of(scene), "a.glb"),
                 [&](std::size_t i) -> Vector3d { return 2 * (corners[i] + 0.5 * moves[i]); });
  scene.nodes = R"({"mesh":0,"scale":[2,2,2],"weights":[-1,0]})";  // those of the node count
  expect_corners(read(glb_of(scene), "a.glb"),
                 [&](std::size_t i) -> Vector3d { return 2 * (corners[i] - moves[i]); });
}

TEST(ScanWriters, InstancesOfANodeOfAGlbAreAllThere) {
  GlbScene scene;
  scene.more = R"("extensionsRequired":["EXT_mesh_gpu_instancing"],"scenes":[{"nodes":[0]}],)";
  scene.nodes =
      R"({"mesh":0,"translation":[0,0,100],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1,"SCALE":2}}}})";
  scene.accessors = {R"("componentType":5126,"count":2,"type":"VEC3")",
                     R"("componentType":5126,"count":2,"type":"VEC3")"};
  scene.views = {floats({1, 0, 0, 0, -30, 0}), floats({1, 1, 1, 3, 2, 1})};
  const auto scan = read(glb_of(scene), "a.glb");
  expect_corners(scan, [&](std::size_t i) -> Vector3d {
    const Vector3d& p = corners[i % 3];
    return i < 3 ? Vector3d(p + Vector3d(1, 0, 100)) : Vector3d(3 * p.x(), 2 * p.y() - 30, p.z() + 100);
  });
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->mesh.triangles.size(), 2u);
}

coloured::Model one_triangle() {
  return {{{0, 0, 0}, {100, 0, 0}, {0, 100, 0}}, {{0.25, 0.5}, {0.75, 0.5}, {0.25, 1}}, {}};
}
const FileBytes some_image = text_bytes("not looked into");

TEST(ScanWriters, TheEmissiveColourOfABlackGlbIsItsColour) {
  coloured::GlbParts parts;
  parts.material = R"("pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1]},"emissiveFactor":[0.5,1,0.25],)"
                   R"("emissiveTexture":{"index":0})";
  const auto scan = read(coloured::glb(one_triangle(), some_image, parts), "a.glb");
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_TRUE(scan->colours);
  EXPECT_EQ(scan->colours->materials[0].image, 0);
  EXPECT_EQ(scan->colours->materials[0].factor, Eigen::Vector3f(0.5f, 1, 0.25f));
  ASSERT_EQ(scan->colour_notes.size(), 1u);
  EXPECT_NE(scan->colour_notes[0].find("emissive"), std::string::npos);
  parts.material = R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"emissiveFactor":[0.5,1,0.25])";
  const auto lit = read(coloured::glb(one_triangle(), some_image, parts), "a.glb");
  ASSERT_TRUE(lit && lit->colours);
  EXPECT_EQ(lit->colours->materials[0].factor, Eigen::Vector3f(1, 1, 1));
  ASSERT_EQ(lit->colour_notes.size(), 1u);
  EXPECT_NE(lit->colour_notes[0].find("ignored"), std::string::npos);
}

TEST(ScanWriters, ABlackKdWithAnImageIsTheImage) {
  const auto with = [](const std::string& library) {
    return read(coloured::obj_zip(one_triangle(), some_image, library), "a.zip");
  };
  for (const char* order : {"newmtl m1\nKd 0.00 0.00 0.00\nmap_Kd texture-1\n",
                            "newmtl m1\nmap_Kd texture-1\nKd 0 0 0\nnewmtl m2\nKd 1 0 0\n"}) {
    const auto scan = with(order);
    ASSERT_TRUE(scan) << scan.error().text();
    ASSERT_TRUE(scan->colours);
    const ScanMaterial& material =
        scan->colours->materials[static_cast<std::size_t>(scan->colours->material[0])];
    EXPECT_EQ(material.image, 0);
    EXPECT_EQ(material.factor, Eigen::Vector3f(1, 1, 1));
    ASSERT_EQ(scan->colour_notes.size(), 1u);
    EXPECT_NE(scan->colour_notes[0].find("Kd 0 0 0"), std::string::npos);
  }
  const auto half = with("newmtl m1\nKd 0.5 0.25 1\nmap_Kd texture-1\n");
  ASSERT_TRUE(half);
  ASSERT_EQ(half->colour_notes.size(), 1u);
  EXPECT_NE(half->colour_notes[0].find("Kd 0.5"), std::string::npos) << half->colour_notes[0];
  const auto lower_case = with("newmtl m1\nkd 0.1 0.6 0.1\n");
  ASSERT_TRUE(lower_case && lower_case->colours);
  EXPECT_NEAR(lower_case->colours->materials[1].factor.y(), linear_from_srgb(0.6f), 1e-6f);
  ASSERT_EQ(lower_case->colour_notes.size(), 1u);
  EXPECT_NE(lower_case->colour_notes[0].find("kd"), std::string::npos);
}

TEST(ScanWriters, MaterialsThatAreNotThereAreNamed) {
  const auto scan = read(coloured::zipped("model.obj",
                                          "mtllib model.mtl\nv 0 0 0\nv 9 0 0\nv 0 9 0\nusemtl m1\nf 1 2 3\n"
                                          "usemtl m2\nf 1 3 2\n",
                                          "newmtl m1\nKd 1 0 0\n", some_image),
                         "a.zip");
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_EQ(scan->colours_missing.size(), 1u);
  EXPECT_NE(scan->colours_missing[0].find("1 of 2 triangles"), std::string::npos) << scan->colours_missing[0];
  const auto alone = read(text_bytes("mtllib a.mtl\nv 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n"), "a.obj");
  ASSERT_TRUE(alone);
  ASSERT_EQ(alone->colours_missing.size(), 1u);
  EXPECT_NE(alone->colours_missing[0].find("mtllib"), std::string::npos);
}

TEST(ScanWriters, ColoursOfAPlyCountAsTheirValuesSay) {
  const auto with = [](const std::string& type, const std::string& first, const std::string& second) {
    const std::string colours =
        "property " + type + " red\nproperty " + type + " green\nproperty " + type + " blue\n";
    return read(
        text_bytes("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                   "float z\n" +
                   colours + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " +
                   first + "\n9 0 0 " + second + "\n0 9 0 0 0 0\n3 0 1 2\n"),
        "a.ply");
  };
  const auto expect = [&](const Result<ScanFile>& scan, std::size_t notes) {
    ASSERT_TRUE(scan) << scan.error().text();
    ASSERT_TRUE(scan->colours);
    const Eigen::Vector3f wanted(linear_from_srgb(200 / 255.0f), linear_from_srgb(100 / 255.0f), 0);
    EXPECT_LT((scan->colours->vertex[0] - wanted).norm(), 1e-4f) << scan->colours->vertex[0].transpose();
    EXPECT_EQ(scan->colour_notes.size(), notes);
  };
  for (const char* type : {"float", "double", "int", "short", "ushort", "uint"}) {
    SCOPED_TRACE(type);
    expect(with(type, "200 100 0", "255 0 1"), 1);
  }
  expect(with("uchar", "200 100 0", "255 0 1"), 0);
  expect(with("float", "0.784313725 0.392156863 0", "1 0 0"), 0);
  expect(with("ushort", "51400 25700 0", "65535 0 0"), 0);
}

}  // namespace
}  // namespace vacuform::scan_writers_test
