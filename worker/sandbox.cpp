// Landlock: Documentation/userspace-api/landlock.rst of Linux; Debian 12's headers know its first ABI alone, so the
// numbers stand here. seccomp: libseccomp builds the filter, the child installs it.
#include "worker/sandbox.hpp"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>

#include "api/sandbox_measures.hpp"

namespace vacuform {

namespace {

constexpr int own_namespaces = CLONE_NEWUSER | CLONE_NEWNET | CLONE_NEWIPC;

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

// Allows rights beneath a path; what does not exist needs no rule.
bool allow(int ruleset, const char* path, std::uint64_t rights) {
  const int fd = ::open(path, O_PATH | O_CLOEXEC);
  if (fd < 0) return errno == ENOENT;
  struct stat status {};
  const bool known = ::fstat(fd, &status) == 0;
  if (!S_ISDIR(status.st_mode)) rights &= execute | write_file | read_file | truncate_file;
  const PathRule rule{rights, fd};
  const bool added = known && ::syscall(add_rule, ruleset, 1, &rule, 0) == 0;
  ::close(fd);
  return added;
}

int make_ruleset(int abi, const std::string& program, const std::string& home, const std::string& kept) {
  const auto [size, all] = all_rights(abi);
  const int ruleset = static_cast<int>(::syscall(create_ruleset, &all, size, 0));
  if (ruleset < 0) return -1;
  constexpr std::uint64_t look = read_file | read_folder;
  const std::uint64_t own = all.files & ~(execute | make_character_device | make_block_device | make_socket);
  bool made = allow(ruleset, home.c_str(), own) && (kept.empty() || allow(ruleset, kept.c_str(), own)) &&
              allow(ruleset, program.c_str(), read_file | execute) &&
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

// What no pipeline needs. Names that the library does not know are those of newer kernels.
constexpr std::array refused_calls{"socket",
                                   "socketpair",
                                   "connect",
                                   "bind",
                                   "listen",
                                   "accept",
                                   "accept4",
                                   "sendto",
                                   "sendmsg",
                                   "sendmmsg",
                                   "ptrace",
                                   "process_vm_readv",
                                   "process_vm_writev",
                                   "process_madvise",
                                   "pidfd_open",
                                   "pidfd_getfd",
                                   "pidfd_send_signal",
                                   "kill",
                                   "tkill",
                                   "rt_sigqueueinfo",
                                   "rt_tgsigqueueinfo",
                                   "mount",
                                   "umount2",
                                   "pivot_root",
                                   "chroot",
                                   "setns",
                                   "unshare",
                                   "open_tree",
                                   "move_mount",
                                   "fsopen",
                                   "fsmount",
                                   "fsconfig",
                                   "fspick",
                                   "mount_setattr",
                                   "open_by_handle_at",
                                   "name_to_handle_at",
                                   "bpf",
                                   "perf_event_open",
                                   "userfaultfd",
                                   "keyctl",
                                   "add_key",
                                   "request_key",
                                   "init_module",
                                   "finit_module",
                                   "delete_module",
                                   "kexec_load",
                                   "kexec_file_load",
                                   "reboot",
                                   "swapon",
                                   "swapoff",
                                   "acct",
                                   "quotactl",
                                   "settimeofday",
                                   "clock_settime",
                                   "adjtimex",
                                   "sethostname",
                                   "setdomainname",
                                   "iopl",
                                   "ioperm",
                                   "personality",
                                   "io_uring_setup",
                                   "io_uring_enter",
                                   "io_uring_register",
                                   "execveat",
                                   "vhangup",
                                   "syslog",
                                   "mknod",
                                   "mknodat",
                                   "setuid",
                                   "setgid",
                                   "setreuid",
                                   "setregid",
                                   "setresuid",
                                   "setresgid",
                                   "setgroups",
                                   "inotify_init",
                                   "inotify_init1",
                                   "fanotify_init"};

struct Release {
  void operator()(void* filter) const { ::seccomp_release(filter); }
};

std::vector<sock_filter> make_filter(const char* program) {
  const std::unique_ptr<void, Release> filter(::seccomp_init(SCMP_ACT_ALLOW));
  if (!filter) return {};
  const std::uint32_t refuse = SCMP_ACT_ERRNO(EPERM);
  bool made = true;
  for (const char* name : refused_calls) {
    const int call = ::seccomp_syscall_resolve_name(name);
    if (call != __NR_SCMP_ERROR) made = made && ::seccomp_rule_add(filter.get(), refuse, call, 0) == 0;
  }
  const auto address = static_cast<scmp_datum_t>(reinterpret_cast<std::uintptr_t>(program));
  made = made &&
         ::seccomp_rule_add(filter.get(), refuse, SCMP_SYS(execve), 1, SCMP_A0(SCMP_CMP_NE, address)) == 0;
  for (const std::uint64_t space :
       {CLONE_NEWUSER, CLONE_NEWNET, CLONE_NEWNS, CLONE_NEWPID, CLONE_NEWIPC, CLONE_NEWUTS, CLONE_NEWCGROUP})
    made = made && ::seccomp_rule_add(filter.get(), refuse, SCMP_SYS(clone), 1,
                                      SCMP_A0(SCMP_CMP_MASKED_EQ, space, space)) == 0;
  // Its flags lie in memory, where no filter sees them; without it the C library uses clone.
  made = made && ::seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0) == 0;
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

// Whether a process can do it; it ends at once.
template <class F>
bool can(const F& attempt) {
  const pid_t pid = ::fork();
  if (pid == 0) ::_exit(attempt() ? 0 : 1);
  int status = 1;
  return pid > 0 && ::waitpid(pid, &status, 0) == pid && status == 0;
}

}  // namespace

Sandbox Sandbox::of_this_machine() {
  constexpr unsigned ask_for_version = 1;
  Sandbox sandbox;
  sandbox.namespaces = can([] { return ::unshare(own_namespaces) == 0; });
  sandbox.landlock = static_cast<int>(std::max(0L, ::syscall(create_ruleset, nullptr, 0, ask_for_version)));
  const std::vector<sock_filter> filter = make_filter(nullptr);
  sandbox.seccomp = !filter.empty() &&
                    can([&] { return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && install(filter); });
  return sandbox;
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
    : sandbox_(other.sandbox_), ruleset_(other.ruleset_), filter_(std::move(other.filter_)) {
  other.ruleset_ = -1;
}
Confinement::~Confinement() {
  if (ruleset_ >= 0) ::close(ruleset_);
}

Result<Confinement> Confinement::prepare(const Sandbox& sandbox, const char* program,
                                         const std::filesystem::path& home,
                                         const std::filesystem::path& kept) {
  Confinement made;
  made.sandbox_ = sandbox;
  if (sandbox.landlock > 0) made.ruleset_ = make_ruleset(sandbox.landlock, program, home, kept);
  if (sandbox.seccomp) made.filter_ = make_filter(program);
  if ((sandbox.landlock > 0 && made.ruleset_ < 0) || (sandbox.seccomp && made.filter_.empty()))
    return fail(Code::internal, "no sandbox could be made for the job", "", "try again later");
  return made;
}

bool Confinement::leave_namespaces() const { return !sandbox_.namespaces || ::unshare(own_namespaces) == 0; }

bool Confinement::leave_files() const { return ruleset_ < 0 || ::syscall(restrict_self, ruleset_, 0) == 0; }

bool Confinement::leave_calls() const { return filter_.empty() || install(filter_); }

}  // namespace vacuform
