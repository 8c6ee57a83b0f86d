// The sandbox of a job's child process: each measure against a child that tries to break it, alone and combined.
#include "worker/agent/sandbox.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "api/base/file_tree.hpp"
#include "worker/agent/child.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

class InSandbox : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sandbox-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
    home = folder / "home";
    fs::create_directory(home);
    std::ofstream(home / "scan.stl") << "solid";
    std::ofstream(folder / "secret") << "a token";
    all = strongest_sandbox(probe.number(), VACUFORM_SANDBOX_PROBE, home, ChildLimits());
  }
  void TearDown() override { fs::remove_all(folder); }

  // The probe's exit status, or minus the signal that ended it.
  int attempt(const Sandbox& sandbox, const std::string& what, const std::string& argument = "",
              const fs::path& kept = {}) {
    ChildLimits limits;
    limits.address_space = 0;
    const auto end = run_child(
        {probe.number(), {VACUFORM_SANDBOX_PROBE, what, argument}, home, limits, sandbox, kept},
        [](const ChildProgress&) {}, [] { return false; });
    EXPECT_TRUE(end);
    return end->how == ChildEnd::How::signalled ? -end->number : end->number;
  }
  // One measure alone, if the machine supports it.
  Sandbox only(bool Sandbox::*measure) const {
    Sandbox one;
    one.*measure = all.*measure;
    return one;
  }
  Sandbox only_landlock() const {
    Sandbox one;
    one.landlock = all.landlock;
    return one;
  }

  const Descriptor probe{::open(VACUFORM_SANDBOX_PROBE, O_PATH | O_CLOEXEC)};
  Sandbox all;
  const Sandbox none;
  fs::path folder, home;
};

// A socket of the test that listens on loopback: a child could reach it without the sandbox.
struct Listener {
  Listener() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address);
    ::listen(socket, 8);
    socklen_t size = sizeof address;
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
    port = std::to_string(ntohs(address.sin_port));
  }
  ~Listener() { ::close(socket); }
  int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::string port;
};

TEST_F(InSandbox, HonestWorkIsDone) {
  EXPECT_EQ(attempt(all, "work"), 0);
  EXPECT_TRUE(fs::exists(home / "out" / "out.txt"));
  EXPECT_EQ(attempt(all, "read", "scan.stl"), 0);
  EXPECT_EQ(attempt(all, "read", "/etc/fonts/fonts.conf"), 0);
  EXPECT_EQ(attempt(all, "abort"), -SIGABRT);  // a crash is still reported as a crash
}

// Everything below succeeds without the sandbox; otherwise the tests would prove nothing.
TEST_F(InSandbox, IsOpenWithoutTheSandbox) {
  const Listener listener;
  EXPECT_EQ(attempt(none, "read", folder / "secret"), 0);
  EXPECT_EQ(attempt(none, "write", folder / "new"), 0);
  EXPECT_EQ(attempt(none, "connect", listener.port), 0);
  EXPECT_EQ(attempt(none, "unix-socket"), 0);
  EXPECT_EQ(attempt(none, "kill", std::to_string(::getpid())), 0);
  EXPECT_EQ(attempt(none, "exec", "/bin/true"), 0);
}

TEST_F(InSandbox, LandlockShowsItsOwnFolderAlone) {
  if (all.landlock == 0) GTEST_SKIP() << "this kernel has no Landlock";
  const Sandbox files = only_landlock();
  EXPECT_EQ(attempt(files, "read", folder / "secret"), EACCES);
  EXPECT_EQ(attempt(files, "read", "/etc/passwd"), EACCES);
  EXPECT_EQ(attempt(files, "read", "/proc/1/environ"), EACCES);
  EXPECT_EQ(attempt(files, "read", "../secret"), EACCES);
  EXPECT_EQ(attempt(files, "write", folder / "new"), EACCES);
  EXPECT_EQ(attempt(files, "write", "/tmp/sandbox-escape"), EACCES);
  EXPECT_EQ(attempt(files, "remove", folder / "secret"), EACCES);
  EXPECT_EQ(attempt(files, "exec", "/bin/true"), EACCES);
  EXPECT_EQ(attempt(files, "write", home / "new"), 0);
  // Older kernels know fewer rights.
  EXPECT_EQ(attempt(files, "kill", std::to_string(::getpid())), all.landlock >= 6 ? EPERM : 0);
  if (all.landlock >= 3) {
    EXPECT_EQ(attempt(files, "truncate", folder / "secret"), EACCES);
  }
  EXPECT_EQ(fs::file_size(folder / "secret"), 7u);
}

TEST_F(InSandbox, LandlockShowsWhatWasKeptOfItsOwnScanAlone) {
  if (all.landlock == 0) GTEST_SKIP() << "this kernel has no Landlock";
  const fs::path own = folder / "kept" / "own", other = folder / "kept" / "other";
  for (const fs::path& scan : {own, other}) {
    fs::create_directories(scan);
    std::ofstream(scan / "a.mold") << "a head";
  }
  const Sandbox files = only_landlock();
  EXPECT_EQ(attempt(files, "read", own / "a.mold", own), 0);
  EXPECT_EQ(attempt(files, "write", own / "b.mold", own), 0);
  EXPECT_EQ(attempt(files, "read", other / "a.mold", own), EACCES);
  EXPECT_EQ(attempt(files, "read", folder / "kept", own), EACCES);  // not even their names
  EXPECT_EQ(attempt(files, "write", other / "b.mold", own), EACCES);
  EXPECT_EQ(attempt(files, "read", own / "a.mold"), EACCES);
}

TEST_F(InSandbox, NamespacesHaveNoNetwork) {
  if (!all.namespaces) GTEST_SKIP() << "this kernel, or the container, gives no user namespaces";
  const Listener listener;
  EXPECT_EQ(attempt(only(&Sandbox::namespaces), "connect", listener.port), ENETUNREACH);
  EXPECT_EQ(attempt(only(&Sandbox::namespaces), "mount", home), EPERM);
}

TEST_F(InSandbox, SeccompRefusesWhatNoPipelineNeeds) {
  if (!all.seccomp) GTEST_SKIP() << "this kernel has no seccomp filters";
  const Sandbox calls = only(&Sandbox::seccomp);
  const Listener listener;
  for (const char* what : {"socket", "unix-socket", "unshare"})
    EXPECT_EQ(attempt(calls, what), EPERM) << what;
  EXPECT_EQ(attempt(calls, "connect", listener.port), EPERM);
  EXPECT_EQ(attempt(calls, "ptrace", std::to_string(::getpid())), EPERM);
  EXPECT_EQ(attempt(calls, "kill", std::to_string(::getpid())), EPERM);
  EXPECT_EQ(attempt(calls, "mount", home), EPERM);
  EXPECT_EQ(attempt(calls, "exec", "/bin/true"), EPERM);
  EXPECT_EQ(attempt(calls, "exec", VACUFORM_SANDBOX_PROBE), EPERM);
}

// Operations that Landlock does not restrict, or not on every kernel.
TEST_F(InSandbox, SeccompRefusesToChangeWhatFilesAreBesidesTheirContent) {
  if (!all.seccomp) GTEST_SKIP() << "this kernel has no seccomp filters";
  const Sandbox calls = only(&Sandbox::seccomp);
  const fs::path secret = folder / "secret";
  for (const char* what : {"chmod", "fchmod", "fchmodat", "chown", "setxattr", "truncate", "empty", "touch",
                           "setsid", "setpgid", "fork", "prlimit", "own-pipe", "mkfifo"})
    EXPECT_EQ(attempt(calls, what, secret), EPERM) << what;
  for (const char* what : {"fchmodat2", "setxattrat"})
    EXPECT_EQ(attempt(calls, what, secret), ENOSYS) << what;
  EXPECT_EQ(fs::file_size(secret), 7u);
  EXPECT_EQ(attempt(none, "chmod", secret), 0);  // it succeeds without the sandbox
  EXPECT_EQ(attempt(none, "empty", secret), 0);
  EXPECT_EQ(fs::file_size(secret), 0u);
}

TEST_F(InSandbox, SignalsReachTheProcessItselfAlone) {
  for (const Sandbox& sandbox : {all, only(&Sandbox::seccomp)}) {
    if (!sandbox.seccomp) GTEST_SKIP() << "this kernel has no seccomp filters";
    EXPECT_EQ(attempt(sandbox, "tgkill", std::to_string(::getpid())), EPERM);
    EXPECT_EQ(attempt(sandbox, "abort"), -SIGABRT);
  }
}

TEST_F(InSandbox, AJobNeedsLandlockAndSeccomp) {
  EXPECT_TRUE((Sandbox{true, 1, true}).is_enough());
  EXPECT_TRUE((Sandbox{false, 2, true}).is_enough());
  EXPECT_FALSE((Sandbox{true, 0, true}).is_enough());
  EXPECT_FALSE((Sandbox{true, 7, false}).is_enough());
}

// An old ABI alone forbids less; together with seccomp it forbids the same.
TEST_F(InSandbox, EveryAbiOfLandlockIsEnoughWithSeccomp) {
  if (!all.is_enough()) GTEST_SKIP() << "this kernel has no Landlock or no seccomp filters";
  for (int abi = 1; abi <= all.landlock; ++abi) {
    const Sandbox old{all.namespaces, abi, true};
    const fs::path secret = folder / "secret";
    EXPECT_EQ(attempt(old, "write", home / "new"), 0) << abi;
    EXPECT_EQ(attempt(old, "read", secret), EACCES) << abi;
    EXPECT_EQ(attempt(old, "write", secret), EACCES) << abi;
    EXPECT_EQ(attempt(old, "remove", secret), EACCES) << abi;
    for (const char* what : {"truncate", "empty", "chmod", "touch"})
      EXPECT_EQ(attempt(old, what, secret), EPERM) << abi << what;
    EXPECT_EQ(attempt(old, "tgkill", std::to_string(::getpid())), EPERM) << abi;
    EXPECT_NE(attempt(old, "link", secret), 0) << abi;
  }
  EXPECT_EQ(fs::file_size(folder / "secret"), 7u);
}

TEST_F(InSandbox, SaysWhatItTakesAndWhatTheMachineLacks) {
  const Sandbox some{true, 0, true};
  EXPECT_EQ(some.measures(true), (std::vector<std::string>{"namespaces", "seccomp"}));
  EXPECT_EQ(some.measures(false), std::vector<std::string>{"landlock"});
}

}  // namespace
}  // namespace vacuform
