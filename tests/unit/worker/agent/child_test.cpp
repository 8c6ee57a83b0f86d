#include "worker/agent/child.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <thread>

#include "api/base/file_tree.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::string content(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Whether a process runs: a zombie that nobody has reaped yet does not.
bool runs(const std::string& pid) {
  const std::string stat = content("/proc/" + pid + "/stat");
  const auto paren = stat.rfind(')');
  return paren != std::string::npos && stat.at(paren + 2) != 'Z' && stat.at(paren + 2) != 'X';
}

template <class Condition>
bool becomes_true(const Condition& condition) {
  for (const auto until = steady_clock::now() + std::chrono::seconds(30); steady_clock::now() < until;) {
    if (condition()) return true;
    std::this_thread::sleep_for(milliseconds(20));
  }
  return condition();
}

class Child : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "child-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    home = name;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    limits.address_space = 0;
#endif
  }
  void TearDown() override { fs::remove_all(home); }

  Result<ChildEnd> run_if_possible(const std::string& script) {
    return run_child(
        {shell.number(), {"/bin/sh", "-c", script}, home, limits, sandbox, {}, groups ? &*groups : nullptr},
        [this](const ChildProgress& at) { seen.push_back(at); }, [this] { return stop(); });
  }
  ChildEnd run(const std::string& script) {
    const auto end = run_if_possible(script);
    EXPECT_TRUE(end) << end.error().text();
    return end.value_or(ChildEnd{});
  }

  const Descriptor shell{::open("/bin/sh", O_PATH | O_CLOEXEC)};
  fs::path home;
  ChildLimits limits;
  Sandbox sandbox;
  std::optional<JobGroups> groups;
  std::vector<ChildProgress> seen;
  std::function<bool()> stop = [] { return false; };
};

TEST_F(Child, TellsProgressAndItsExitStatus) {
  const auto end =
      run(R"(echo '{"stage":"scan","progress":0.5}'; echo junk; echo '{"stage":"forming","progress":1}')");
  EXPECT_EQ(end.how, ChildEnd::How::exited);
  EXPECT_EQ(end.number, 0);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].stage, Stage::scan);
  EXPECT_EQ(seen[0].fraction, 0.5);
  EXPECT_EQ(seen[1].stage, Stage::forming);
  EXPECT_FALSE(end.problem);
}

TEST_F(Child, TellsItsProblem) {
  const auto end = run(
      R"(echo '{"problem":{"code":"does-not-fit","what":"too wide","where":"scan.stl","fix":"turn it"}}'; exit 2)");
  EXPECT_EQ(end.how, ChildEnd::How::exited);
  EXPECT_EQ(end.number, 2);
  ASSERT_TRUE(end.problem);
  EXPECT_EQ(end.problem->code, Code::does_not_fit);
  EXPECT_EQ(end.problem->text(), "too wide (scan.stl); turn it");
}

TEST_F(Child, HasNothingOfItsWorkersEnvironment) {
  ::setenv("VACUFORM_SECRET", "1", 1);
  const auto end =
      run("env | sort > env; cat > stdin; ulimit -n > files; ulimit -c > core; grep NoNewPrivs "
          "/proc/self/status > privileges;"
          "ls /proc/self/fd | wc -l > open");
  EXPECT_EQ(end.number, 0);
  const std::string env = content(home / "env");
  EXPECT_NE(env.find("HOME=" + home.string() + "\n"), std::string::npos) << env;
  EXPECT_NE(env.find("LANG=C.UTF-8\n"), std::string::npos) << env;
  EXPECT_EQ(env.find("VACUFORM_SECRET"), std::string::npos) << env;
  EXPECT_EQ(content(home / "stdin"), "");
  EXPECT_EQ(content(home / "files"), "64\n");
  EXPECT_EQ(content(home / "core"), "0\n");
  EXPECT_EQ(content(home / "privileges"), "NoNewPrivs:\t1\n");
  EXPECT_EQ(std::stoi(content(home / "open")), 5);  // 0, 1, 2, its own program and the one that ls reads
}

TEST_F(Child, CrashIsASignal) {
  const auto end = run("echo oh dear >&2; kill -SEGV $$");
  EXPECT_EQ(end.how, ChildEnd::How::signalled);
  EXPECT_EQ(end.number, SIGSEGV);
  EXPECT_EQ(end.stderr_tail, "oh dear\n");
}

TEST_F(Child, ProgramThatDoesNotExistIsNoSuccess) {
  const auto end = run_child(
      {-1, {"/no/such/program"}, home, limits, {}}, [](const ChildProgress&) {}, stop);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->how, ChildEnd::How::exited);
  EXPECT_EQ(end->number, 126);
}

TEST_F(Child, WallLimitEndsASleeper) {
  limits.wall = milliseconds(200);
  const auto end = run("sleep 300");
  EXPECT_EQ(end.how, ChildEnd::How::out_of_time);
  ASSERT_TRUE(end.problem);
  EXPECT_EQ(end.problem->code, Code::out_of_time);
}

TEST_F(Child, ProcessorLimitEndsABusyLoop) {
  limits.cpu_seconds = 1;
  const auto end = run("while :; do :; done");
  EXPECT_EQ(end.how, ChildEnd::How::out_of_time);
  ASSERT_TRUE(end.problem);
  EXPECT_NE(end.problem->what.find("1 s of processor time"), std::string::npos) << end.problem->what;
}

TEST_F(Child, FileLimitEndsAWriter) {
  limits.file_size = 1000000;
  const auto end = run("exec head -c 2000000 /dev/zero > large");
  EXPECT_EQ(end.how, ChildEnd::How::out_of_time);
  EXPECT_EQ(fs::file_size(home / "large"), 1000000u);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(Child, MemoryLimitHolds) {
  limits.address_space = 256u << 20;
  const auto end = run("exec dd if=/dev/zero of=/dev/null bs=512M count=1");
  EXPECT_EQ(end.how, ChildEnd::How::exited);
  EXPECT_EQ(end.number, 1);
  EXPECT_NE(end.stderr_tail.find("memory exhausted"), std::string::npos) << end.stderr_tail;
}
#endif

TEST_F(Child, StopEndsOneThatIgnoresSigterm) {
  const fs::path ready = home / "ready";
  stop = [&] { return fs::exists(ready); };
  const auto end = run("trap '' TERM; echo > ready; while :; do sleep 0.05; done");
  EXPECT_EQ(end.how, ChildEnd::How::stopped);
}

TEST_F(Child, StopLetsOneEndByItself) {
  const fs::path ready = home / "ready";
  stop = [&] { return fs::exists(ready); };
  const auto end = run("trap 'echo bye > bye; exit 0' TERM; echo > ready; while :; do sleep 0.01; done");
  EXPECT_EQ(end.how, ChildEnd::How::stopped);
  EXPECT_EQ(content(home / "bye"), "bye\n");
}

TEST_F(Child, NothingOfItsGroupSurvives) {
  const auto end = run("sleep 300 & echo $! > pid");
  EXPECT_EQ(end.number, 0);
  std::string pid = content(home / "pid");
  pid.pop_back();
  EXPECT_TRUE(becomes_true([&] { return !runs(pid); }));
}

TEST_F(Child, DiesWithItsWorker) {
  const pid_t worker = ::fork();
  if (worker == 0) {
    (void)run_child(
        {shell.number(), {"/bin/sh", "-c", "echo $$ > pid; sleep 300 & wait"}, home, limits, {}},
        [](const ChildProgress&) {}, stop);
    ::_exit(0);
  }
  ASSERT_TRUE(becomes_true([&] { return content(home / "pid").find('\n') != std::string::npos; }));
  std::string pid = content(home / "pid");
  pid.pop_back();
  EXPECT_TRUE(runs(pid));
  ::kill(worker, SIGKILL);
  ::waitpid(worker, nullptr, 0);
  EXPECT_TRUE(becomes_true([&] { return !runs(pid); }));
}

// A daemon of the program's, in a session of its own and with no parent; it tells its number as this machine knows it.
constexpr const char* daemon =
    "setsid sh -c 'read self rest < /proc/self/stat; echo $self > pid; exec sleep 300' & "
    "until [ -s pid ]; do sleep 0.01; done";

TEST_F(Child, ADaemonEndsWithTheProgram) {
  EXPECT_EQ(run(daemon).number, 0);
  EXPECT_FALSE(runs(std::to_string(std::stoi(content(home / "pid")))));
}

TEST_F(Child, ADaemonEndsWithACancelledProgram) {
  stop = [&] { return fs::exists(home / "ready"); };
  EXPECT_EQ(run(std::string("trap '' TERM; ") + daemon + "; echo > ready; while :; do sleep 0.05; done").how,
            ChildEnd::How::stopped);
  EXPECT_FALSE(runs(std::to_string(std::stoi(content(home / "pid")))));
}

// Each starts the next in a session of its own, and ends: no one process leads to the last.
TEST_F(Child, GenerationsOfProcessesEndWithTheProgram) {
  const auto end =
      run("printf '[ $1 = 0 ] && { read self rest < /proc/self/stat; echo $self > pid; exec sleep 300; }; "
          "setsid sh ./next $(($1 - 1)) &' > next; sh ./next 10; until [ -s pid ]; do sleep 0.01; done");
  EXPECT_EQ(end.number, 0);
  EXPECT_FALSE(runs(std::to_string(std::stoi(content(home / "pid")))));
}

class ChildInNamespaces : public Child {
 protected:
  void SetUp() override {
    Child::SetUp();
    sandbox.namespaces = true;
    if (!run_if_possible("true")) GTEST_SKIP() << "this kernel, or the container, gives no user namespaces";
  }
};

TEST_F(ChildInNamespaces, ADaemonEndsWithTheProgram) {
  EXPECT_EQ(run(daemon).number, 0);
  EXPECT_FALSE(runs(std::to_string(std::stoi(content(home / "pid")))));
}

TEST_F(ChildInNamespaces, HowTheProgramEndedIsTold) {
  EXPECT_EQ(run("exit 7").number, 7);
  const auto crashed = run("kill -SEGV $$");
  EXPECT_EQ(crashed.how, ChildEnd::How::signalled);
  EXPECT_EQ(crashed.number, SIGSEGV);
  const auto killed = run("kill -KILL $$");
  EXPECT_EQ(killed.how, ChildEnd::How::signalled);
  EXPECT_EQ(killed.number, SIGKILL);
  limits.cpu_seconds = 1;
  EXPECT_EQ(run("while :; do :; done").how, ChildEnd::How::out_of_time);
}

TEST_F(ChildInNamespaces, ACancelledProgramMayEndByItselfAndMustEnd) {
  stop = [&] { return fs::exists(home / "ready"); };
  EXPECT_EQ(run("trap 'echo bye > bye; exit 0' TERM; echo > ready; while :; do sleep 0.01; done").how,
            ChildEnd::How::stopped);
  EXPECT_EQ(content(home / "bye"), "bye\n");
  fs::remove(home / "ready");
  const auto asked = steady_clock::now();
  EXPECT_EQ(run("trap '' TERM; echo > ready; while :; do sleep 0.05; done").how, ChildEnd::How::stopped);
  EXPECT_LT(steady_clock::now() - asked, std::chrono::seconds(10));
}

TEST_F(ChildInNamespaces, DiesWithItsWorker) {
  const pid_t worker = ::fork();
  if (worker == 0) {
    (void)run(std::string(daemon) + "; sleep 300");
    ::_exit(0);
  }
  ASSERT_TRUE(becomes_true([&] { return content(home / "pid").find('\n') != std::string::npos; }));
  const std::string pid = std::to_string(std::stoi(content(home / "pid")));
  EXPECT_TRUE(runs(pid));
  ::kill(worker, SIGKILL);
  ::waitpid(worker, nullptr, 0);
  EXPECT_TRUE(becomes_true([&] { return !runs(pid); }));
}

// In a part of the tree of control groups that this test makes, and so owns.
class ChildInGroup : public Child {
 protected:
  void SetUp() override {
    Child::SetUp();
    std::ifstream mounts("/proc/self/mounts");
    for (std::string device, where, type, rest;
         mounts >> device >> where >> type && std::getline(mounts, rest);)
      if (type == "cgroup2") tree = where;
    std::string name = tree / "child-test-XXXXXX";
    if (tree.empty() || ::mkdtemp(name.data()) == nullptr)
      GTEST_SKIP() << "no cgroup v2 that this user may change";
    folder = name;
    std::ofstream(folder / "cgroup.procs") << 0;
    EXPECT_FALSE(JobGroups::delegated());
    ASSERT_EQ(::setxattr(folder.c_str(), "user.delegate", "1", 1, 0), 0);
    groups = JobGroups::delegated();
    ASSERT_TRUE(groups);
  }
  void TearDown() override {
    if (!folder.empty()) {
      std::ofstream(tree / "cgroup.procs") << 0;
      EXPECT_EQ(::rmdir((folder / "worker").c_str()), 0);
      EXPECT_EQ(::rmdir(folder.c_str()), 0) << "a job's group is left";
    }
    Child::TearDown();
  }
  bool has(const std::string& controller) const {
    const auto& all = groups->controllers();
    return std::find(all.begin(), all.end(), controller) != all.end();
  }
  fs::path tree, folder;
};

TEST_F(ChildInGroup, IsInAGroupOfItsOwnThatGoesWithIt) {
  EXPECT_EQ(run("cat /proc/self/cgroup > group").number, 0);
  EXPECT_NE(content(home / "group").find("0::/" + folder.filename().string() + "/job-"), std::string::npos);
  EXPECT_NE(content("/proc/self/cgroup").find("0::/" + folder.filename().string() + "/worker\n"),
            std::string::npos);
  sandbox.namespaces = true;
  if (run_if_possible("true")) {
    EXPECT_EQ(run("exit 7").number, 7);  // 126 where it could not join
  }
}

TEST_F(ChildInGroup, NothingSurvivesEvenWhereItEndsItsSupervisor) {
  (void)run("setsid sh -c 'echo $$ > pid; kill -KILL $1; sleep 300' sh $PPID & sleep 300");
  EXPECT_TRUE(becomes_true([&] { return !runs(std::to_string(std::stoi(content(home / "pid")))); }));
}

TEST_F(ChildInGroup, WhatAnEarlierWorkerLeftEnds) {
  const fs::path left = folder / "job-left";
  fs::create_directory(left);
  const pid_t job = ::fork();
  if (job == 0) {
    std::ofstream(left / "cgroup.procs") << 0 << std::flush;
    ::pause();
  }
  ASSERT_TRUE(becomes_true([&] { return !content(left / "cgroup.procs").empty(); }));
  EXPECT_TRUE(JobGroups::in(folder));
  int status = 0;
  ::waitpid(job, &status, 0);
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  EXPECT_FALSE(fs::exists(left));
}

// Of the controllers that the kernel gives to cgroup v2: all memory counts, that of several processes too.
TEST_F(ChildInGroup, ItsLimitsHold) {
  const std::string offered = content(tree / "cgroup.subtree_control");
  EXPECT_EQ(has("memory"), offered.find("memory") != std::string::npos);
  EXPECT_EQ(has("pids"), offered.find("pids") != std::string::npos);
  if (has("memory")) {
    limits.address_space = 64u << 20;
    const auto end = run("for i in 1 2 3 4; do head -c 40000000 /dev/zero | tail -n 1 | wc -c & done; wait");
    EXPECT_EQ(end.how, ChildEnd::How::signalled);
    EXPECT_EQ(end.number, SIGKILL);
    EXPECT_TRUE(end.out_of_memory);
  }
  if (has("pids")) {
    limits.tasks = 8;
    const auto end = run("for i in 1 2 3 4 5 6 7 8 9 10; do sleep 1 & done; wait");
    EXPECT_NE(end.stderr_tail.find("fork"), std::string::npos) << end.stderr_tail;
  }
}

TEST_F(Child, FloodOfStderrKeepsItsEnd) {
  const auto end = run("head -c 5000000 /dev/zero | tr '\\0' x >&2; echo the end >&2");
  EXPECT_EQ(end.number, 0);
  EXPECT_EQ(end.stderr_tail.size(), 65536u);
  EXPECT_EQ(end.stderr_tail.substr(end.stderr_tail.size() - 9), "xthe end\n");
}

TEST_F(Child, FloodOfStdoutIsDroppedLineByLine) {
  const auto end =
      run(R"(head -c 5000000 /dev/zero | tr '\0' x; echo; echo '{"stage":"printing","progress":0.25}')");
  EXPECT_EQ(end.number, 0);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].fraction, 0.25);
}

TEST(ChildLine, HostileLinesAreNothing) {
  for (const char* line :
       {"", "null", "[]", "{}", "{\"stage\":\"forming\"}", "{\"stage\":\"forming\",\"progress\":\"1\"}",
        "{\"stage\":\"forming\",\"progress\":1.001}", "{\"stage\":\"forming\",\"progress\":-0.1}",
        "{\"stage\":\"forming\",\"progress\":1e999}", "{\"stage\":\"melting\",\"progress\":0.5}",
        "{\"stage\":3,\"progress\":0.5}", "{\"problem\":\"bad\"}", "{\"problem\":{}}",
        "{\"problem\":{\"code\":\"no-such-code\",\"what\":\"x\"}}", "{\"problem\":{\"code\":\"internal\"}}",
        "{\"problem\":{\"code\":\"internal\",\"what\":[1]}}", "{\"stage\":\"forming\",\"progress\":0.5",
        "{\"stage\":\"forming\",\"progress\":0.5}}", "\xff\xfe{\"stage\":\"forming\",\"progress\":0.5}"})
    EXPECT_TRUE(std::holds_alternative<std::monostate>(parse_child_line(line))) << line;
  EXPECT_TRUE(std::holds_alternative<std::monostate>(parse_child_line(std::string(10000, '['))));
}

TEST(ChildLine, LongTextsAreCutBetweenCharacters) {
  std::string what;
  for (int i = 0; i < 3000; ++i) what += "ä";
  const ChildLine line = parse_child_line(R"({"problem":{"code":"corrupt-file","what":"x)" + what + "\"}}");
  ASSERT_TRUE(std::holds_alternative<Error>(line));
  EXPECT_EQ(std::get<Error>(line).what.size(), 1999u);  // 1 + 2 * 999: the 1000th would pass 2000
}

}  // namespace
}  // namespace vacuform
