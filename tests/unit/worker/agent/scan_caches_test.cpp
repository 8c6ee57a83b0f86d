// What a worker keeps of scans, and the lines that it adds to a job's log.
#include "worker/agent/scan_caches.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

#include "worker/agent/job_log.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

class ScanCachesTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "scan-caches-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::string digest(char c) { return std::string(64, c); }
  ScanCaches open(std::uint64_t most_bytes, std::chrono::hours longest = std::chrono::hours(24)) const {
    return ScanCaches::open(folder / "cache", most_bytes, longest).value();
  }
  // A scan's subfolder with so many bytes, last used so long ago.
  fs::path used(const ScanCaches& caches, char c, std::size_t bytes, std::chrono::hours ago) const {
    const fs::path scan = caches.of(digest(c)).value();
    std::ofstream(scan / "a.mold") << std::string(bytes, 'x');
    fs::last_write_time(scan, fs::file_time_type::clock::now() - ago);
    return scan;
  }

  fs::path folder;
};

TEST_F(ScanCachesTest, EachScanHasAPrivateFolder) {
  const ScanCaches caches = open(100);
  const fs::path scan = caches.of(digest('a')).value();
  EXPECT_EQ(scan, folder / "cache" / digest('a'));
  EXPECT_EQ(fs::status(scan).permissions(), fs::perms::owner_all);
  EXPECT_EQ(caches.of(digest('a')).value(), scan);
  for (const std::string& bad : {std::string("../x"), std::string(), digest('A'), digest('a') + "/"})
    EXPECT_EQ(caches.of(bad).error().code, Code::bad_usage) << bad;
}

TEST_F(ScanCachesTest, MakesTheFolderAboveForThisUserAlone) {
  ASSERT_TRUE(ScanCaches::open(folder / "a" / "work" / "cache", 1, std::chrono::hours(1)));
  EXPECT_EQ(fs::status(folder / "a" / "work").permissions(), fs::perms::owner_all);
}

TEST_F(ScanCachesTest, AFolderThatOthersReadIsRefused) {
  fs::create_directory(folder / "cache");
  fs::permissions(folder / "cache", fs::perms::owner_all | fs::perms::others_read);
  EXPECT_EQ(ScanCaches::open(folder / "cache", 1, std::chrono::hours(1)).error().code, Code::unreadable);
  fs::create_directory_symlink(folder, folder / "link");
  EXPECT_EQ(ScanCaches::open(folder / "link", 1, std::chrono::hours(1)).error().code, Code::unreadable);
}

TEST_F(ScanCachesTest, DeletesTheLeastRecentlyUsedScanFirst) {
  using std::chrono::hours;
  const ScanCaches caches = open(250);
  const fs::path old = used(caches, 'a', 100, hours(3)), middle = used(caches, 'b', 100, hours(2)),
                 young = used(caches, 'c', 100, hours(1));
  std::ofstream(folder / "cache" / "notes.txt") << "not of this kind";
  EXPECT_EQ(caches.make_room(), 1);
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(middle) && fs::exists(young) && fs::exists(folder / "cache" / "notes.txt"));
  ASSERT_TRUE(caches.of(digest('b')));  // used again
  used(caches, 'd', 100, hours(0));
  EXPECT_EQ(caches.make_room(), 1);
  EXPECT_TRUE(fs::exists(middle));
  EXPECT_FALSE(fs::exists(young));
}

TEST_F(ScanCachesTest, DeletesAScanThatIsLongUnused) {
  using std::chrono::hours;
  const ScanCaches caches = open(1000, hours(48));
  const fs::path old = used(caches, 'a', 1, hours(49)), young = used(caches, 'b', 1, hours(47));
  EXPECT_EQ(caches.make_room(), 1);
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(young));
}

TEST_F(ScanCachesTest, SeriousWarningsOfAReportAreCounted) {
  const auto serious = [&](const std::string& text) {
    std::ofstream(folder / "report.json", std::ios::trunc) << text;
    return reported_warnings(
               {Descriptor(::open((folder / "report.json").c_str(), O_RDONLY | O_CLOEXEC)), text.size()})
        .serious;
  };
  EXPECT_EQ(serious(R"({"warnings":[{"severity":"serious"},{"severity":"note"},{"severity":"serious"},3]})"),
            2);
  EXPECT_EQ(serious(R"({"warnings":[]})"), 0);
  EXPECT_EQ(serious("[1]"), std::nullopt);
  std::string many = R"({"warnings":[)";
  for (int i = 0; i < 2000; ++i) many += R"({"severity":"serious"},)";
  EXPECT_EQ(serious(many + "1]}"), 1000);
}

TEST_F(ScanCachesTest, OnlyCodesOfAReportReachTheLog) {
  const auto codes = [&](const std::string& text) {
    std::ofstream(folder / "report.json", std::ios::trunc) << text;
    return reported_warnings(
               {Descriptor(::open((folder / "report.json").c_str(), O_RDONLY | O_CLOEXEC)), text.size()})
        .codes;
  };
  EXPECT_EQ(
      codes(R"({"warnings":[{"code":"undercut","what":"of Jane Roe"},{"code":"Jane Roe"},{"code":7},3]})"),
      std::vector<std::string>{"undercut"});
  EXPECT_TRUE(codes("").empty());
  EXPECT_TRUE(codes("[1]").empty());
  EXPECT_TRUE(codes(R"({"warnings":{"code":"x"}})").empty());
  std::string many = R"({"warnings":[)";
  for (int i = 0; i < 80; ++i) many += R"({"code":"thin"},)";
  EXPECT_EQ(codes(many + "1]}").size(), 50u);
}

TEST_F(ScanCachesTest, AFolderWithTooManyFilesOrWithFoldersIsDeleted) {
  const ScanCaches caches = open(1000000);
  const fs::path crowded = used(caches, 'a', 1, std::chrono::hours(0)),
                 deep = used(caches, 'b', 1, std::chrono::hours(0)),
                 good = used(caches, 'c', 1, std::chrono::hours(0));
  for (std::size_t i = 0; i < ScanCaches::most_files; ++i) std::ofstream(crowded / std::to_string(i));
  fs::create_directory(deep / "folder");
  fs::permissions(deep / "folder", fs::perms::none);
  EXPECT_EQ(caches.make_room(), 2);
  EXPECT_FALSE(fs::exists(crowded) || fs::exists(deep));
  EXPECT_TRUE(fs::exists(good));
}

}  // namespace
}  // namespace vacuform
