// Scans as strangers' programs write them: the files of the folder cases, and what each must do.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "api/redaction/redaction.hpp"
#include "tests/real/real_scans.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform::cases_test {
namespace {

using Eigen::Vector3d;

std::optional<real::FileBytes> case_of(const std::string& name) { return real::read("../cases/" + name); }

// The file as it is, and as it is stored: without names.
std::vector<real::FileBytes> both(const std::string& name) {
  const auto bytes = case_of(name);
  if (!bytes) return {};
  real::FileBytes stored = *bytes;
  EXPECT_TRUE(redact(stored, name));
  return {*bytes, stored};
}

Result<Mold> mold_of(const real::FileBytes& bytes, const std::string& name, const ScanSettings& given = {}) {
  return make_mold(bytes, name, given, Context());
}
ScanSettings in_mm() {
  ScanSettings settings;
  settings.units = Unit::mm;
  return settings;
}
Result<ScanFile> colours_of(const real::FileBytes& bytes, const std::string& name) {
  const Context context;
  return read_scan(bytes, name, ScanProgress(context), ScanParts::with_colours);
}

#define VACUFORM_NEED_CASE(name)                                \
  if (!case_of(name) && real::required())                       \
    FAIL() << real::missing(std::string("../cases/") + (name)); \
  else if (!case_of(name))                                      \
  GTEST_SKIP() << real::missing(std::string("../cases/") + (name))

TEST(Cases, SloppyStlIsReadWhole) {
  VACUFORM_NEED_CASE("head.stl");
  const auto right = mold_of(*case_of("head.stl"), "head.stl", in_mm());
  ASSERT_TRUE(right);
  for (const char* name :
       {"count0.stl", "two_solids_bin.stl", "upper.stl", "bom.stl", "endsolid_upper.stl", "end_solid.stl"}) {
    SCOPED_TRACE(name);
    for (const auto& bytes : both(name)) {
      const auto mold = mold_of(bytes, name, in_mm());
      ASSERT_TRUE(mold) << mold.error().text();
      EXPECT_NEAR((mold->findings.size_mm - right->findings.size_mm).norm(), 0, 1);
      EXPECT_EQ(mold->findings.up, right->findings.up);
      EXPECT_NEAR(mold->findings.trim_mm, right->findings.trim_mm, 1);
    }
  }
  EXPECT_EQ(mold_of(*case_of("count0.stl"), "count0.stl", in_mm())->findings.triangles_read, 3360);
  EXPECT_EQ(mold_of(*case_of("two_solids_bin.stl"), "a.stl", in_mm())->findings.triangles_read, 3360);
}

TEST(Cases, TheAxesOf3dSlicerPlaceTheHead) {
  VACUFORM_NEED_CASE("slicer_lps.stl");
  for (const auto& bytes : both("slicer_lps.stl")) {
    const auto mold = mold_of(bytes, "slicer_lps.stl", in_mm());
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_EQ(mold->findings.space, PatientSpace::lps);
    EXPECT_EQ(mold->findings.front, FrontSide::minus_y);
    EXPECT_EQ(mold->findings.left_from_file, FrontSide::plus_x);
    EXPECT_TRUE(mold->findings.front_from_format);
    // -y of the file is the front, and its +x the left of the patient.
    const Vector3d origin = mold->placing(Vector3d::Zero());
    EXPECT_NEAR((mold->placing(Vector3d(0, -1, 0)) - origin).y(), 1, 1e-9);
    EXPECT_NEAR((mold->placing(Vector3d(1, 0, 0)) - origin).x(), -1, 1e-9);
  }
}

TEST(Cases, EachProposalForAFigurineWorks) {
  VACUFORM_NEED_CASE("small60.stl");
  const auto bytes = *case_of("small60.stl");
  const auto asked = mold_of(bytes, "small60.stl");
  ASSERT_FALSE(asked);
  bool in_millimetres = false;
  for (const Proposal& proposal : asked.error().proposals) {
    ASSERT_EQ(proposal.set.size(), 1u);
    ASSERT_EQ(proposal.set[0].name, "scan.units");
    ScanSettings settings;
    settings.units = proposal.set[0].word == "mm" ? Unit::mm : Unit::cm;
    const auto mold = mold_of(bytes, "small60.stl", settings);
    ASSERT_TRUE(mold) << proposal.set[0].word << " " << mold.error().text();
    if (settings.units != Unit::mm) continue;
    in_millimetres = true;
    EXPECT_NEAR(mold->findings.size_mm.z(), 62, 0.2);
    EXPECT_TRUE(check_fit(*mold, {}, {}));
  }
  EXPECT_TRUE(in_millimetres);
}

TEST(Cases, SkinsHoldTheHead) {
  VACUFORM_NEED_CASE("skin_scale.glb");
  for (const auto& [name, height] : {std::pair{"skin_scale.glb", 262.1}, std::pair{"skin_root.glb", 209.7}}) {
    SCOPED_TRACE(name);
    for (const auto& bytes : both(name)) {
      const auto mold = mold_of(bytes, name);
      ASSERT_TRUE(mold) << mold.error().text();
      EXPECT_EQ(mold->findings.unit, Unit::m);
      EXPECT_EQ(mold->findings.up, UpAxis::plus_y);
      EXPECT_NEAR(mold->findings.size_mm.z(), height, 0.5);
      EXPECT_NEAR(mold->findings.size_mm.y(), height * 211.5 / 209.7, 0.5);
    }
  }
}

TEST(Cases, ColoursAreThoseThatTheFileMeans) {
  VACUFORM_NEED_CASE("emissive.glb");
  for (const auto& bytes : both("emissive.glb")) {
    const auto scan = colours_of(bytes, "emissive.glb");
    ASSERT_TRUE(scan) << scan.error().text();
    ASSERT_TRUE(scan->colours);
    EXPECT_EQ(scan->colours->images.size(), 1u);
    EXPECT_EQ(scan->colours->materials[0].factor, Eigen::Vector3f(1, 1, 1));
  }
  for (const auto& bytes : both("col255.ply")) {
    const auto scan = colours_of(bytes, "col255.ply");
    ASSERT_TRUE(scan) << scan.error().text();
    ASSERT_TRUE(scan->colours);
    EXPECT_NEAR(scan->colours->vertex[0].x(), linear_from_srgb(200 / 255.0f), 1e-4);
    EXPECT_NEAR(scan->colours->vertex[0].z(), linear_from_srgb(50 / 255.0f), 1e-4);
  }
}

}  // namespace
}  // namespace vacuform::cases_test
