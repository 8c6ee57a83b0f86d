// What a job's child may not do, tried: sandbox_probe WHAT [ARGUMENT]. Exits with 0 when it was done, otherwise with the
// errno of the refusal.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

namespace {

int outcome(long result) { return result < 0 ? errno : 0; }

int open_file(const char* path, int flags) { return outcome(::open(path, flags, 0600)); }

int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  if (socket < 0) return errno;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return outcome(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address));
}

// What an honest pipeline does: files of its own, threads, libraries.
int work() {
  std::ofstream("out.txt") << "bytes";
  std::string read;
  std::ifstream("out.txt") >> read;
  int made = 0;
  std::thread([&] {
    made = ::mkdir("out", 0700) == 0 && ::rename("out.txt", "out/out.txt") == 0 ? 1 : 0;
  }).join();
  return read == "bytes" && made == 1 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const char* argument = argc > 2 ? argv[2] : "";
  if (what == "--version") return 0;  // the trial of a sandbox
  if (what == "work") return work();
  if (what == "read") return open_file(argument, O_RDONLY);
  if (what == "write") return open_file(argument, O_WRONLY | O_CREAT);
  if (what == "truncate") return outcome(::truncate(argument, 0));
  if (what == "remove") return outcome(::unlink(argument));
  if (what == "socket") return outcome(::socket(AF_INET, SOCK_STREAM, 0));
  if (what == "unix-socket") return outcome(::socket(AF_UNIX, SOCK_STREAM, 0));
  if (what == "connect") return connect_to(std::atoi(argument));
  if (what == "ptrace") return outcome(::ptrace(PTRACE_ATTACH, std::atoi(argument), nullptr, nullptr));
  if (what == "mount") return outcome(::mount("none", argument, "tmpfs", 0, nullptr));
  if (what == "unshare") return outcome(::unshare(CLONE_NEWUSER));
  if (what == "kill") return outcome(::kill(std::atoi(argument), SIGCONT));
  if (what == "exec") return outcome(::execl(argument, argument, nullptr));
  if (what == "chmod") return outcome(::chmod(argument, 0666));
  if (what == "fchmod") return outcome(::fchmod(0, 0666));
  if (what == "fchmodat") return outcome(::fchmodat(AT_FDCWD, argument, 0666, 0));
  if (what == "fchmodat2") return outcome(::syscall(452, AT_FDCWD, argument, 0666, 0));
  if (what == "chown") return outcome(::chown(argument, ::geteuid(), ::getegid()));
  if (what == "setxattr") return outcome(::setxattr(argument, "user.x", "y", 1, 0));
  if (what == "setxattrat") return outcome(::syscall(463, AT_FDCWD, argument, 0, "user.x", nullptr, 0));
  if (what == "empty") return open_file(argument, O_RDONLY | O_TRUNC);
  if (what == "touch") return outcome(::utimensat(AT_FDCWD, argument, nullptr, 0));
  if (what == "link") return outcome(::link(argument, "stolen"));
  if (what == "mkfifo") return outcome(::mkfifo("fifo", 0600));
  if (what == "setsid") return outcome(::setsid());
  if (what == "setpgid") return outcome(::setpgid(0, 0));
  if (what == "fork") {
    const pid_t pid = ::fork();
    if (pid == 0) ::_exit(0);
    return outcome(pid);
  }
  if (what == "tgkill")
    return outcome(::syscall(SYS_tgkill, std::atoi(argument), std::atoi(argument), SIGCONT));
  if (what == "prlimit") {
    rlimit limit{};
    return outcome(::syscall(SYS_prlimit64, ::getppid() + 1, RLIMIT_CPU, nullptr, &limit));
  }
  if (what == "own-pipe") {
    int ends[2];
    return ::pipe(ends) == 0 ? outcome(::fcntl(ends[0], F_SETOWN, 1)) : 254;
  }
  if (what == "abort") ::abort();
  return 255;
}
