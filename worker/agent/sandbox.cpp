// Landlock: Documentation/userspace-api/landlock.rst of Linux. The headers of Debian 12 have only its first ABI, so the
// numbers are defined here. seccomp: libseccomp builds the filter, the child installs it.
#include "worker/agent/sandbox.hpp"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "api/sandbox_measures.hpp"

namespace vacuform {

namespace {

constexpr int own_namespaces = CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET | CLONE_NEWIPC;
constexpr int program_number = 3;     // the descriptor of the program, when it is executed
constexpr const char* no_path = "";   // execveat() executes the descriptor itself
constexpr int last_known_call = 450;  // of Linux 5.17; from 424 on the numbers are the same on every machine

struct RulesetAttributes {
  std::uint64_t files, net, scoped;
};
struct PathRule {
  std::uint64_t allowed;
  std::int32_t parent;
} __attribute__((packed));

constexpr long create_ruleset = 444, add_rule = 445, restrict_self = 446;
constexpr std::uint64_t execute = 1 << 0, write_file = 1 << 1, read_file = 1 << 2, read_folder = 1 << 3,
                        make_character_device = 1 << 6, make_socket = 1 << 9, make_block_device = 1 << 11,
                        truncate_file = 1 << 14;

// What the ABI can forbid: the size of its attributes, and all of its rights.
std::pair<std::size_t, RulesetAttributes> all_rights(int abi) {
  RulesetAttributes all{(1 << 13) - 1, 0, 0};
  if (abi >= 2) all.files |= 1 << 13;  // moving between folders
  if (abi >= 3) all.files |= truncate_file;
  if (abi >= 4) all.net = 3;           // TCP: bind, connect
  if (abi >= 5) all.files |= 1 << 15;  // ioctl on devices
  if (abi >= 6) all.scoped = 3;        // abstract sockets and signals, outside
  return {abi >= 6 ? 24 : abi >= 4 ? 16 : 8, all};
}

// Allows rights beneath an open file or folder.
bool allow(int ruleset, int fd, std::uint64_t rights) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return false;
  if (!S_ISDIR(status.st_mode)) rights &= execute | write_file | read_file | truncate_file;
  const PathRule rule{rights, fd};
  return ::syscall(add_rule, ruleset, 1, &rule, 0) == 0;
}

// Allows rights beneath a path. A path that does not exist needs no rule.
bool allow(int ruleset, const char* path, std::uint64_t rights) {
  const int fd = ::open(path, O_PATH | O_CLOEXEC);
  if (fd < 0) return errno == ENOENT;
  const bool added = allow(ruleset, fd, rights);
  ::close(fd);
  return added;
}

int make_ruleset(int abi, int program, const std::string& home, const std::string& cache) {
  const auto [size, all] = all_rights(abi);
  const int ruleset = static_cast<int>(::syscall(create_ruleset, &all, size, 0));
  if (ruleset < 0) return -1;
  constexpr std::uint64_t look = read_file | read_folder;
  const std::uint64_t own = all.files & ~(execute | make_character_device | make_block_device | make_socket);
  bool made = allow(ruleset, home.c_str(), own) && (cache.empty() || allow(ruleset, cache.c_str(), own)) &&
              allow(ruleset, program, read_file | execute) &&
              allow(ruleset, "/dev/null", read_file | write_file);
  for (const char* loader : {"/lib", "/lib64", "/usr/lib", "/usr/lib64"})
    made = made && allow(ruleset, loader, look | execute);  // the dynamic loader is run, not only read
  for (const char* system : {"/usr", "/etc/fonts", "/etc/ld.so.cache", "/var/cache/fontconfig",
                             "/dev/urandom", "/sys/devices/system/cpu", "/proc/cpuinfo", "/proc/meminfo"})
    made = made && allow(ruleset, system, look);
  if (made) return ruleset;
  ::close(ruleset);
  return -1;
}

// What a pipeline needs: files that it may open, memory, threads, clocks. Everything else is refused: the network, other
// processes, modes and owners of files, memory that no limit counts (memfd_create), and what the kernel learns next year.
// Landlock guards the contents of files. Some of these calls are allowed with few arguments only: see make_filter().
constexpr std::array allowed_calls{
    // files
    "read", "write", "readv", "writev", "pread64", "pwrite64", "preadv", "pwritev", "lseek", "_llseek",
    "close", "close_range", "fstat", "stat", "lstat", "fstat64", "newfstatat", "fstatat64", "statx", "access",
    "faccessat", "faccessat2", "readlink", "readlinkat", "getdents", "getdents64", "getcwd", "chdir",
    "fchdir", "mkdir", "mkdirat", "rmdir", "unlink", "unlinkat", "rename", "renameat", "renameat2", "link",
    "linkat", "ftruncate", "ftruncate64", "fsync", "fdatasync", "statfs", "statfs64", "fstatfs", "fstatfs64",
    "fadvise64", "copy_file_range", "sendfile", "sendfile64", "flock", "umask", "dup", "dup2", "dup3", "pipe",
    "pipe2", "poll", "ppoll", "select", "pselect6",
    // memory
    "mmap", "mmap2", "munmap", "mprotect", "mremap", "madvise", "brk",
    // threads, and signals of this process
    "futex", "set_robust_list", "get_robust_list", "rseq", "set_tid_address", "gettid", "sched_yield",
    "sched_getaffinity", "getcpu", "membarrier", "tgkill", "rt_sigaction", "rt_sigprocmask", "rt_sigreturn",
    "rt_sigpending", "rt_sigsuspend", "sigaltstack", "restart_syscall", "exit", "exit_group", "arch_prctl",
    // clocks, and what the process may know of itself and the machine
    "clock_gettime", "clock_getres", "clock_nanosleep", "nanosleep", "gettimeofday", "time", "times",
    "getrusage", "getrandom", "uname", "sysinfo", "getpid", "getppid", "getuid", "geteuid", "getgid",
    "getegid", "getrlimit", "setrlimit"};

struct Release {
  void operator()(void* filter) const { ::seccomp_release(filter); }
};

std::vector<sock_filter> make_filter() {
  const std::unique_ptr<void, Release> filter(::seccomp_init(SCMP_ACT_ERRNO(EPERM)));
  if (!filter) return {};
  constexpr std::uint64_t word = 0xffffffff;  // an int: the kernel ignores the rest of its register
  bool made = true;
  const auto add = [&](std::uint32_t action, int call, const auto&... arguments) {
    made = made && ::seccomp_rule_add(filter.get(), action, call, sizeof...(arguments), arguments...) == 0;
  };
  const auto allow_call = [&](int call, const auto&... arguments) {
    add(SCMP_ACT_ALLOW, call, arguments...);
  };
  for (const char* name : allowed_calls)  // calls unknown to the library do not exist on this machine
    if (const int call = ::seccomp_syscall_resolve_name(name); call != __NR_SCMP_ERROR) allow_call(call);
  // Threads only, in no new namespace. The flags of clone3 are in memory, where no filter sees them; without it the C
  // library uses clone.
  constexpr std::uint64_t spaces = CLONE_NEWUSER | CLONE_NEWNET | CLONE_NEWNS | CLONE_NEWPID | CLONE_NEWIPC |
                                   CLONE_NEWUTS | CLONE_NEWCGROUP;
  allow_call(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD | spaces, CLONE_THREAD));
  add(SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3));
  // Only the program of the descriptor, by an address that disappears with the old memory once it runs.
  const auto address = static_cast<scmp_datum_t>(reinterpret_cast<std::uintptr_t>(no_path));
  allow_call(SCMP_SYS(execveat), SCMP_A0(SCMP_CMP_EQ, program_number), SCMP_A1(SCMP_CMP_EQ, address),
             SCMP_A4(SCMP_CMP_EQ, AT_EMPTY_PATH));
  // No truncating of a file that is opened for reading, which Landlock does not see before its third ABI.
  constexpr std::uint64_t emptying = O_TRUNC | O_ACCMODE;
  for (const std::uint64_t flags :
       {O_RDONLY, O_WRONLY, O_RDWR, O_TRUNC | O_WRONLY, O_TRUNC | O_RDWR, O_ACCMODE, O_TRUNC | O_ACCMODE}) {
    allow_call(SCMP_SYS(openat), SCMP_A2(SCMP_CMP_MASKED_EQ, emptying, flags));
#ifdef __NR_open
    allow_call(SCMP_SYS(open), SCMP_A1(SCMP_CMP_MASKED_EQ, emptying, flags));
#endif
  }
  add(SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(openat2));
  // Only the times of files that it has open, and only to the present.
  allow_call(SCMP_SYS(utimensat), SCMP_A1(SCMP_CMP_EQ, 0), SCMP_A2(SCMP_CMP_EQ, 0));
  // Only its own limits.
  allow_call(SCMP_SYS(prlimit64), SCMP_A0(SCMP_CMP_EQ, 0));
  // No signals that the kernel would send for it.
  for (const int command : {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_GETLK, F_SETLK,
                            F_SETLKW, F_OFD_GETLK, F_OFD_SETLK, F_OFD_SETLKW})
    allow_call(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_MASKED_EQ, word, static_cast<scmp_datum_t>(command)));
  // The rules of install_own_rules(); a job that adds some takes away from itself alone.
  allow_call(SCMP_SYS(prctl), SCMP_A0(SCMP_CMP_EQ, PR_SET_SECCOMP));
  add(SCMP_ACT_ERRNO(ENOTTY), SCMP_SYS(ioctl));  // as a plain file answers
  const int file = made ? ::memfd_create("filter", MFD_CLOEXEC) : -1;
  std::vector<sock_filter> program_code;
  if (file >= 0 && ::seccomp_export_bpf(filter.get(), file) == 0) {
    const auto bytes = static_cast<std::size_t>(::lseek(file, 0, SEEK_END));
    program_code.resize(bytes / sizeof(sock_filter));
    if (::pread(file, program_code.data(), bytes, 0) != static_cast<ssize_t>(bytes)) program_code.clear();
  }
  if (file >= 0) ::close(file);
  return program_code;
}

bool install(const std::vector<sock_filter>& filter) {
  const sock_fprog code{static_cast<unsigned short>(filter.size()), const_cast<sock_filter*>(filter.data())};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &code) == 0;
}

// The rules that libseccomp cannot write: calls that are newer than its names, and a number that only the child knows.
// The filter before this one has already checked the architecture that the numbers belong to.
bool install_own_rules() {
  constexpr std::uint32_t first_argument =
      offsetof(seccomp_data, args) + (std::endian::native == std::endian::big ? 4 : 0);
  const auto self = static_cast<std::uint32_t>(::getpid());
  const sock_filter code[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, last_known_call, 5, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_tgkill, 0, 2),  // abort() sends one to itself
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, first_argument),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, self, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
  };
  const sock_fprog program{std::size(code), const_cast<sock_filter*>(code)};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

}  // namespace

Sandbox Sandbox::all() {
  constexpr unsigned ask_for_version = 1;
  return {true, static_cast<int>(std::max(0L, ::syscall(create_ruleset, nullptr, 0, ask_for_version))), true};
}

std::vector<std::string> Sandbox::measures(bool taken) const {
  std::vector<std::string> names;
  const std::array<bool, sandbox_measures.size()> takes{namespaces, landlock > 0, seccomp};
  for (std::size_t i = 0; i < takes.size(); ++i)
    if (takes[i] == taken) names.emplace_back(sandbox_measures[i]);
  return names;
}

Confinement::Confinement() = default;
Confinement::Confinement(Confinement&& other) noexcept
    : sandbox_(other.sandbox_),
      program_(other.program_),
      ruleset_(other.ruleset_),
      filter_(std::move(other.filter_)) {
  other.ruleset_ = -1;
}
Confinement::~Confinement() {
  if (ruleset_ >= 0) ::close(ruleset_);
}

Result<Confinement> Confinement::prepare(const Sandbox& sandbox, int program,
                                         const std::filesystem::path& home,
                                         const std::filesystem::path& cache) {
  Confinement made;
  made.sandbox_ = sandbox;
  made.program_ = program;
  if (sandbox.landlock > 0) made.ruleset_ = make_ruleset(sandbox.landlock, program, home, cache);
  if (sandbox.seccomp) made.filter_ = make_filter();
  if ((sandbox.landlock > 0 && made.ruleset_ < 0) || (sandbox.seccomp && made.filter_.empty()))
    return fail(Code::internal, "no sandbox could be made for the job", "", "try again later");
  return made;
}

unsigned long Confinement::namespaces() const { return sandbox_.namespaces ? own_namespaces : 0; }

bool Confinement::leave_files() const { return ruleset_ < 0 || ::syscall(restrict_self, ruleset_, 0) == 0; }

bool Confinement::hold_program() const {
  // dup2() to the same number would leave the close-on-exec flag set.
  return ::dup2(program_, program_number) == program_number && ::fcntl(program_number, F_SETFD, 0) == 0 &&
         ::close_range(program_number + 1, ~0u, 0) == 0;
}

bool Confinement::leave_calls() const { return filter_.empty() || (install(filter_) && install_own_rules()); }

void Confinement::execute(char* const* argv, char* const* envp) const {
  ::syscall(SYS_execveat, program_number, no_path, argv, envp, AT_EMPTY_PATH);
}

}  // namespace vacuform
