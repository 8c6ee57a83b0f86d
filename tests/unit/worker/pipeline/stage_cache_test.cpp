#include "worker/pipeline/stage_cache.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/unit/fixtures/shapes.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

class StageCacheTest : public testing::Test {
 protected:
  StageCacheTest() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / (std::string("vacuform-cache-") + test->name());
    fs::remove_all(folder);
    mold = hemisphere(40, 12, 24);
    mold.findings.format = "STL (binary)";
    mold.findings.trim_mm = 12.5;
    mold.undercuts = {{{1, 2, 3}, 4, 5}};
    mold.warnings = {{"undercut", "There is one", {{{1, 2, 3}, 4}}}};
  }
  ~StageCacheTest() override { fs::remove_all(folder); }

  std::vector<fs::path> files() const {
    std::vector<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  fs::path folder;
  Mold mold;
};

TEST_F(StageCacheTest, AMoldComesBackAsItWas) {
  const StageCache cache(folder);
  EXPECT_FALSE(cache.mold({{"scan", "a"}}));
  cache.store({{"scan", "a"}}, mold);
  const auto back = cache.mold({{"scan", "a"}});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->mesh.vertices, mold.mesh.vertices);
  EXPECT_EQ(back->mesh.triangles, mold.mesh.triangles);
  EXPECT_EQ(back->top, mold.top);
  EXPECT_EQ(back->findings.format, "STL (binary)");
  EXPECT_EQ(back->findings.trim_mm, 12.5);
  ASSERT_EQ(back->undercuts.size(), 1u);
  EXPECT_EQ(back->undercuts[0].area_mm2, 5);
  ASSERT_EQ(back->warnings.size(), 1u);
  EXPECT_EQ(back->warnings[0].text, "There is one");
  EXPECT_EQ(back->warnings[0].marks[0].size_mm, 4);
  EXPECT_FALSE(cache.mold({{"scan", "b"}}));
  EXPECT_FALSE(cache.sheet({{"scan", "a"}}));
  // Only the owner may read a head.
  EXPECT_EQ(fs::status(folder).permissions(), fs::perms::owner_all);
  EXPECT_EQ(fs::status(files()[0]).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(StageCacheTest, ASheetComesBackAsItWas) {
  SheetSettings sheet;
  sheet.resolution_mm = 15;
  const auto formed = form(mold, sheet, {}, {}, TemperatureField(120), Context{});
  ASSERT_TRUE(formed);
  const StageCache cache(folder);
  cache.store({{"sheet", 1}}, *formed);
  const auto back = cache.sheet({{"sheet", 1}});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->triangles, formed->triangles);
  EXPECT_EQ(back->rest, formed->rest);
  EXPECT_EQ(back->formed, formed->formed);
  EXPECT_EQ(back->contact, formed->contact);
  EXPECT_EQ(back->thickness, formed->thickness);
  EXPECT_EQ(back->element_thickness, formed->element_thickness);
  EXPECT_EQ(back->element_wrinkled, formed->element_wrinkled);
  EXPECT_EQ(back->summary.iterations, formed->summary.iterations);
  EXPECT_EQ(back->summary.residual, formed->summary.residual);
  EXPECT_EQ(back->vents.size(), formed->vents.size());
  EXPECT_EQ(back->warnings.size(), formed->warnings.size());
}

// A file that is cut anywhere, or has any byte changed, counts as missing.
TEST_F(StageCacheTest, ADamagedFileIsNotUsed) {
  mold.mesh.vertices.resize(3), mold.mesh.triangles = {{0, 1, 2}};
  const StageCache cache(folder);
  cache.store({{"scan", "a"}}, mold);
  const fs::path path = files()[0];
  std::string whole;
  {
    std::ifstream in(path, std::ios::binary);
    whole.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto with = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
    return cache.mold({{"scan", "a"}}).has_value();
  };
  EXPECT_TRUE(with(whole));
  for (std::size_t n = 0; n < whole.size(); n += 7) EXPECT_FALSE(with(whole.substr(0, n))) << n;
  for (std::size_t i = 0; i < whole.size(); i += 5) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x10);
    EXPECT_FALSE(with(changed)) << i;
  }
  EXPECT_FALSE(with(whole + "x"));
}

TEST_F(StageCacheTest, TheOldestMakeRoom) {
  const StageCache cache(folder, {}, 1'000'000'000);
  cache.store({{"scan", "a"}}, mold);
  const auto size = fs::file_size(files()[0]);
  const auto hours_ago = [&](const fs::path& path, int hours) {
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  hours_ago(files()[0], 3);
  cache.store({{"scan", "b"}}, mold);
  for (const fs::path& path : files())
    if (fs::last_write_time(path) > fs::file_time_type::clock::now() - std::chrono::hours(1))
      hours_ago(path, 2);
  ASSERT_TRUE(cache.mold({{"scan", "a"}}));  // used: now the more recent one
  const StageCache tight(folder, {}, 2 * size + 1);
  tight.store({{"scan", "c"}}, mold);
  EXPECT_TRUE(tight.mold({{"scan", "a"}}));
  EXPECT_FALSE(tight.mold({{"scan", "b"}}));
  EXPECT_TRUE(tight.mold({{"scan", "c"}}));
}

TEST_F(StageCacheTest, KeepNothingWithoutAFolder) {
  const StageCache none;
  none.store({{"scan", "a"}}, mold);
  EXPECT_FALSE(none.mold({{"scan", "a"}}));
  const StageCache unwritable("/proc/no/such/folder");
  unwritable.store({{"scan", "a"}}, mold);
  EXPECT_FALSE(unwritable.mold({{"scan", "a"}}));
}

}  // namespace
}  // namespace vacuform
