#include "worker/work_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

namespace vacuform {
namespace {

namespace fs = std::filesystem;

class WorkFolders : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "work-folder-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    parent = fs::path(name) / "work";
  }
  void TearDown() override { fs::remove_all(parent.parent_path()); }
  fs::path parent;
};

TEST_F(WorkFolders, ArePrivateAndGoWithTheirJob) {
  ASSERT_TRUE(sweep(parent));
  fs::path path;
  {
    const auto folder = WorkFolder::make(parent);
    ASSERT_TRUE(folder);
    path = folder->path();
    struct stat info {};
    ASSERT_EQ(::stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0700u);
    fs::create_directories(path / "out");
    std::ofstream(path / "out" / "print.png") << "bytes";
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(WorkFolders, OfTheLivingStayAndOfTheDeadGo) {
  ASSERT_TRUE(sweep(parent));
  const auto living = WorkFolder::make(parent);
  ASSERT_TRUE(living);
  const pid_t worker = ::fork();
  if (worker == 0) {
    const auto left = WorkFolder::make(parent);
    std::ofstream(left->path() / "scan.stl") << "a head";
    ::kill(::getpid(), SIGKILL);
  }
  ASSERT_EQ(::waitpid(worker, nullptr, 0), worker);
  EXPECT_EQ(std::distance(fs::directory_iterator(parent), {}), 2);
  EXPECT_EQ(sweep(parent), 1);
  EXPECT_TRUE(fs::exists(living->path()));
  EXPECT_EQ(std::distance(fs::directory_iterator(parent), {}), 1);
}

TEST_F(WorkFolders, SweepTouchesNothingElse) {
  ASSERT_TRUE(sweep(parent));
  fs::create_directories(parent / "other");
  std::ofstream(parent / "job-file") << "not a folder";
  EXPECT_EQ(sweep(parent), 0);
  EXPECT_TRUE(fs::exists(parent / "other"));
  EXPECT_TRUE(fs::exists(parent / "job-file"));
}

TEST_F(WorkFolders, ParentThatIsNoFolderIsRefused) {
  std::ofstream(parent) << "a file";
  const auto swept = sweep(parent);
  ASSERT_FALSE(swept);
  EXPECT_EQ(swept.error().code, Code::unreadable);
  EXPECT_EQ(swept.error().where, parent.string());
}

}  // namespace
}  // namespace vacuform
