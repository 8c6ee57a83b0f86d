// A job's program that means harm, in the place of `vacuform`: what a parser that a scan has taken over could do. It tries
// everything at once and tells in report.json what it was able to do. settings.json says by print.dpi what it is to leave
// behind; what to attack is at the end of its own file, a line each: "NAME PATH-OR-NUMBER".
#include <dirent.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "api/job.hpp"

namespace {

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::multimap<std::string, std::string> targets() {
  const std::string self = content("/proc/self/exe"), mark = std::string("\n#TARGETS") + "\n";
  std::multimap<std::string, std::string> found;
  const auto at = self.rfind(mark);
  std::istringstream lines(at == std::string::npos ? "" : self.substr(at + mark.size()));
  for (std::string name, value; lines >> name >> value;) found.emplace(name, value);
  return found;
}

void write_artifacts(const std::string& report = "{}") {
  ::mkdir("out", 0700);
  for (const vacuform::ArtifactKind& kind : vacuform::artifact_kinds)
    std::ofstream("out/" + std::string(kind.name)) << (kind.name == "report.json"     ? report
                                                       : kind.name.ends_with(".json") ? "{}"
                                                                                      : "mine");
}

// What was done, by name; each gives true when it was.
std::string tried(const std::multimap<std::string, std::string>& at) {
  std::string done;
  const auto attempt = [&](const std::string& name, const std::function<bool()>& what) {
    if (what()) done += (done.empty() ? "\"" : ",\"") + name + "\"";
  };
  for (const auto& [name, path] : at) {
    const char* p = path.c_str();
    if (name == "secret") {
      attempt("read " + path, [&] { return !content(path).empty(); });
      attempt("write " + path, [&] { return ::open(p, O_WRONLY) >= 0; });
      attempt("empty " + path, [&] { return ::open(p, O_RDONLY | O_TRUNC) >= 0; });
      attempt("truncate " + path, [&] { return ::truncate(p, 0) == 0; });
      attempt("chmod " + path, [&] { return ::chmod(p, 0666) == 0; });
      attempt("fchmodat2 " + path, [&] { return ::syscall(452, AT_FDCWD, p, 0666, 0) == 0; });
      attempt("chown " + path, [&] { return ::chown(p, 1, 1) == 0; });
      attempt("setxattr " + path, [&] { return ::setxattr(p, "user.x", "y", 1, 0) == 0; });
      attempt("setxattrat " + path, [&] {
        struct {
          std::uint64_t value;
          std::uint32_t size, flags;
        } a{reinterpret_cast<std::uint64_t>("y"), 1, 0};
        return ::syscall(463, AT_FDCWD, p, 0, "user.z", &a, sizeof a) == 0;
      });
      attempt("utimensat " + path, [&] { return ::utimensat(AT_FDCWD, p, nullptr, 0) == 0; });
      attempt("link " + path, [&] { return ::link(p, "stolen") == 0; });
      attempt("rename " + path, [&] { return ::rename(p, "stolen") == 0; });
      attempt("unlink " + path, [&] { return ::unlink(p) == 0; });
    }
    if (name == "folder") {
      attempt("list " + path, [&] { return ::opendir(p) != nullptr; });
      attempt("chmod " + path, [&] { return ::chmod(p, 0777) == 0; });
      attempt("create in " + path,
              [&] { return ::open((path + "/new").c_str(), O_CREAT | O_WRONLY, 0600) >= 0; });
    }
    if (name == "process") {
      const pid_t pid = std::stoi(path);
      attempt("kill " + path, [&] { return ::kill(pid, SIGURG) == 0; });
      attempt("tgkill " + path, [&] { return ::syscall(SYS_tgkill, pid, pid, SIGURG) == 0; });
      attempt("ptrace " + path, [&] { return ::ptrace(PTRACE_ATTACH, pid, nullptr, nullptr) == 0; });
      attempt("environ " + path, [&] { return !content("/proc/" + path + "/environ").empty(); });
      attempt("mem " + path, [&] { return ::open(("/proc/" + path + "/mem").c_str(), O_RDWR) >= 0; });
      attempt("prlimit " + path, [&] {
        const rlimit none{0, 0};
        return ::syscall(SYS_prlimit64, pid, RLIMIT_CPU, &none, nullptr) == 0;
      });
      attempt("signal by a pipe " + path, [&] {
        int ends[2];
        return ::pipe(ends) == 0 && ::fcntl(ends[0], F_SETOWN, pid) == 0;
      });
    }
    if (name == "port")
      attempt("connect " + path, [&] {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(path)));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return ::connect(::socket(AF_INET, SOCK_STREAM, 0), reinterpret_cast<sockaddr*>(&address),
                         sizeof address) == 0;
      });
    if (name == "abstract")
      attempt("connect @" + path, [&] {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path + 1, p, sizeof address.sun_path - 2);
        const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + path.size());
        return ::connect(::socket(AF_UNIX, SOCK_STREAM, 0), reinterpret_cast<sockaddr*>(&address), size) == 0;
      });
  }
  attempt("exec", [] {
    const pid_t pid = ::fork();
    if (pid == 0) {
      ::execl("/bin/true", "true", nullptr);
      ::_exit(9);
    }
    int status = 0;
    return pid > 0 && ::waitpid(pid, &status, 0) == pid && status == 0;
  });
  attempt("memfd_create", [] { return ::memfd_create("hidden", 0) >= 0; });  // memory that no limit counts
  attempt("sync", [] { return ::syscall(SYS_sync) == 0; });
  attempt("future", [] {
    const int file = ::open("dated", O_CREAT | O_RDWR, 0600);
    const timespec times[2] = {{9'000'000'000, 0}, {9'000'000'000, 0}};
    return ::futimens(file, times) == 0;
  });
  attempt("unshare", [] { return ::unshare(CLONE_NEWUSER) == 0; });
  attempt("setsid", [] { return ::setsid() >= 0; });
  attempt("setpgid", [] { return ::setpgid(0, 0) == 0; });
  return done;
}

// Leaves its process twice over, so that no group and no parent leads to it; true in the process that is left.
bool escape() {
  const pid_t pid = ::fork();
  if (pid != 0) {
    if (pid > 0) ::waitpid(pid, nullptr, 0);
    return false;
  }
  ::setsid();
  if (::fork() != 0) ::_exit(0);
  ::setsid();
  return true;
}

void exchange(const char* a, const char* b) { ::syscall(SYS_renameat2, AT_FDCWD, a, AT_FDCWD, b, 2); }

void replace_report(const std::function<void()>& with) {
  write_artifacts();
  ::unlink("out/report.html");
  with();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "--version") == 0) return 0;
  const std::string settings = content("settings.json");
  const auto at = settings.find("\"dpi\":", settings.find("\"print\":"));
  const int what = at == std::string::npos ? 100 : std::atoi(settings.c_str() + at + 6);
  const auto aims = targets();
  const auto first = aims.find("secret");
  const std::string secret = first == aims.end() ? "" : first->second;
  switch (what) {
    case 101:
      write_artifacts("{\"done\":[" + tried(aims) + "],\"warnings\":[]}");
      return 0;
    case 102:  // swaps a file for a link to another while the worker hands it in
      write_artifacts();
      (void)!::symlink(secret.c_str(), "out/swapped");
      for (int i = 0; i < 4; ++i)
        if (escape())
          for (;;) exchange("out/report.html", "out/swapped");
      return 0;
    case 103:
      return ::symlink("out", "out") == 0 ? 0 : 1;
    case 104:
      replace_report([] { ::mkfifo("out/report.html", 0600); });
      return 0;
    case 105:
      replace_report([&] { (void)!::link(secret.c_str(), "out/report.html"); });
      return 0;
    case 106:
      write_artifacts();
      for (int i = 0; i < 20000; ++i) ::close(::open(std::to_string(i).c_str(), O_CREAT | O_WRONLY, 0));
      return 0;
    case 107:  // folders that nobody may enter, and more levels than a path has room for
      write_artifacts();
      ::umask(0);
      ::mkdir("locked", 0700);
      ::mkdir("locked/inner", 0700);
      std::ofstream("locked/inner/scan") << "a head";
      for (const char* folder : {"locked/inner", "locked"}) {
        ::chmod(folder, 0);
        ::mkdir((std::string(folder) + "-made").c_str(), 0);
      }
      for (int i = 0; i < 3000; ++i)
        if (::mkdir("deep", 0700) != 0 || ::chdir("deep") != 0) break;
      return 0;
    case 108:  // outlives its job and goes on writing
      write_artifacts();
      for (int i = 0; i < 8; ++i)
        if (escape())
          for (;;) {
            std::ofstream("out/report.html") << "late";
            ::usleep(1000);
          }
      return 0;
    case 109:
      replace_report([&] { (void)!::symlink(secret.c_str(), "out/report.html"); });
      return 0;
    case 110:
      write_artifacts();
      ::rename("out", "elsewhere");
      (void)!::symlink("/", "out");
      return 0;
    case 111: {  // fills the disk with a file that has no name
      write_artifacts();
      const int file = ::open("ghost", O_CREAT | O_RDWR, 0600);
      ::unlink("ghost");
      const std::string much(1 << 20, 'x');
      while (::write(file, much.data(), much.size()) > 0) {
      }
      for (;;) ::pause();
    }
    default:
      write_artifacts();
      return 0;
  }
}
