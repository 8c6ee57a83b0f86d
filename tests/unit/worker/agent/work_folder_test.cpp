#include "worker/agent/work_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "worker/agent/job_file.hpp"

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

TEST_F(WorkFolders, StayForRunningWorkersAndGoForDeadOnes) {
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

// What a hostile job may leave: folders that nobody may enter, more levels than a path has room for, very many files.
void leave_a_mess(const fs::path& folder) {
  fs::create_directories(folder / "locked" / "inner");
  std::ofstream(folder / "locked" / "inner" / "scan") << "a head";
  for (const char* name : {"locked/inner", "locked"}) fs::permissions(folder / name, fs::perms::none);
  for (int i = 0; i < 1500; ++i) std::ofstream(folder / std::to_string(i));
  fs::create_symlink(folder.parent_path(), folder / "link");
  const Descriptor start(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  Descriptor at(::dup(start.number()));
  for (int i = 0; i < 1500; ++i) {
    ASSERT_EQ(::mkdirat(at.number(), ".below-0", 0700), 0);  // a name that the removal uses too
    ASSERT_EQ(::mkdirat(at.number(), "d", 0700), 0);
    at = open_folder(at.number(), "d", false);
    ASSERT_TRUE(at);
  }
}

TEST_F(WorkFolders, AMessIsDeletedWithoutPermissionAndWithoutRecursion) {
  ASSERT_TRUE(sweep(parent));
  const pid_t as_nobody = ::fork();  // root would need no permission
  if (as_nobody == 0) {
    if (::geteuid() == 0 &&
        (::chmod(parent.parent_path().c_str(), 0755) != 0 || ::chown(parent.c_str(), 65534, 65534) != 0 ||
         ::setresuid(65534, 65534, 65534) != 0))
      ::_exit(2);
    fs::path left;
    {
      const auto folder = WorkFolder::make(parent);
      if (!folder) ::_exit(3);
      left = folder->path();
      leave_a_mess(left);
      ::chmod(left.c_str(), 0);
    }
    ::_exit(fs::exists(left) ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(as_nobody, &status, 0), as_nobody);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::exists(parent.parent_path()));
}

TEST_F(WorkFolders, AMessOfTheDeadIsSweptUp) {
  ASSERT_TRUE(sweep(parent));
  fs::create_directory(parent / "job-dead");
  leave_a_mess(parent / "job-dead");
  fs::permissions(parent / "job-dead", fs::perms::none);
  EXPECT_EQ(sweep(parent), 1);
  EXPECT_TRUE(fs::is_empty(parent));
}

TEST_F(WorkFolders, TheSizeOfAMessIsMeasuredInBoundedTime) {
  fs::create_directories(parent);
  leave_a_mess(parent);
  const Descriptor folder(::open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const TreeSize size = measure_tree(folder.number(), {100, 4, 1000});
  EXPECT_FALSE(size.within);
  EXPECT_LE(size.entries, 101u);
}

class JobFiles : public WorkFolders {
 protected:
  void SetUp() override {
    WorkFolders::SetUp();
    fs::create_directories(parent / "out");
    std::ofstream(parent.parent_path() / "secret") << "a token";
    home = Descriptor(::open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  }
  std::string refusal(const char* name) const {
    const auto file = open_job_file(home.number(), "out", name, 1000);
    return file ? "" : file.error().what.substr(file.error().what.find(": ") + 2);
  }
  Descriptor home;
};

TEST_F(JobFiles, APlainFileIsRead) {
  std::ofstream(parent / "out" / "report.html") << "mine";
  const auto file = open_job_file(home.number(), "out", "report.html", 1000);
  ASSERT_TRUE(file && *file);
  EXPECT_EQ((*file)->bytes, 4u);
  EXPECT_FALSE(open_job_file(home.number(), "out", "absent", 1000).value());
  EXPECT_FALSE(open_job_file(home.number(), "absent", "report.html", 1000).value());
}

TEST_F(JobFiles, NothingElseIs) {
  const fs::path out = parent / "out", secret = parent.parent_path() / "secret";
  fs::create_symlink(secret, out / "link");
  fs::create_symlink("out/../loop", out / "loop");
  ASSERT_EQ(::mkfifo((out / "fifo").c_str(), 0600), 0);
  fs::create_hard_link(secret, out / "hard");
  fs::create_directory(out / "folder");
  std::ofstream(out / "large") << std::string(1001, 'x');
  EXPECT_EQ(refusal("link"), "a symbolic link");
  EXPECT_EQ(refusal("loop"), "a symbolic link");
  EXPECT_EQ(refusal("fifo"), "not a regular file");
  EXPECT_EQ(refusal("hard"), "it has a second name (a hard link)");
  EXPECT_EQ(refusal("folder"), "not a regular file");
  EXPECT_EQ(refusal("large"), "it is too large");
  fs::rename(out, parent / "elsewhere");
  fs::create_symlink("out", out);
  EXPECT_EQ(refusal("report.html"), "the folder is a link or a file");
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
