#include "worker/agent/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/json_text.hpp"
#include "api/base/utf8.hpp"
#include "api/problem.hpp"

namespace vacuform {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::size_t longest_line = 16u << 10;
constexpr std::size_t stderr_limit = 64u << 10;
constexpr std::size_t longest_text = 2000;
constexpr milliseconds grace{500};  // from SIGTERM to SIGKILL: stages check for cancellation every 0.2 s

struct Pipe {
  int read = -1, write = -1;
  bool open() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return false;
    read = ends[0];
    write = ends[1];
    return true;
  }
  void close_write() {
    if (write >= 0) ::close(write);
    write = -1;
  }
  void close_read() {
    if (read >= 0) ::close(read);
    read = -1;
  }
  ~Pipe() {
    close_write();
    close_read();
  }
};

// Cuts a text that may be much too long, without splitting a UTF-8 sequence.
std::string cut(std::string text) {
  if (text.size() <= longest_text) return text;
  std::size_t end = longest_text;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  text.resize(end);
  return text;
}

bool limit(int resource, std::uint64_t soft, std::uint64_t hard) {
  const rlimit r{static_cast<rlim_t>(soft), static_cast<rlim_t>(hard)};
  return ::setrlimit(static_cast<__rlimit_resource>(resource), &r) == 0;
}

constexpr int cannot_confine = 126;  // exit status of a child that cannot be confined or executed

// Everything that the two new processes need. They must not allocate, because other threads may have held locks.
struct Start {
  char* const* argv;
  char* const* envp;
  const char* home;
  const ChildLimits& limits;
  const Confinement& confinement;
  int group;                  // to write "0" to, and so join the control group; -1: none
  int out, err;               // to write to
  int ended, worker_listens;  // the two ends of a pipe for the exit status of the program
};

// Without new namespaces: the fork() of the C library, which sanitizers know. With them, and inside them: a bare
// clone().
pid_t fork_process(bool bare, unsigned long namespaces) {
  return bare ? static_cast<pid_t>(::syscall(SYS_clone, namespaces | SIGCHLD, 0, 0, 0, 0)) : ::fork();
}

// Between fork and exec: only async-signal-safe calls. A step that fails ends the child: no partial sandbox.
[[noreturn]] void exec_program(const Start& start, pid_t supervisor) {
  for (const int number : {SIGPIPE, SIGTERM, SIGINT, SIGHUP, SIGCHLD, SIGUSR1}) ::signal(number, SIG_DFL);
  sigset_t no_signals;
  ::sigemptyset(&no_signals);
  const ChildLimits& limits = start.limits;
  const Confinement& confinement = start.confinement;
  // In a PID namespace the kernel counts the processes of the job, elsewhere those of all workers of this user.
  const std::uint64_t tasks = limits.tasks * (confinement.namespaces() ? 1 : 32);
  const int null = ::open("/dev/null", O_RDONLY);
  // Where memory runs out, the job goes and not the worker. Where there is no /proc, the limits hold alone.
  if (const int score = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC); score >= 0)
    (void)!::write(score, "1000", 4);
  const bool ready =
      ::sigprocmask(SIG_SETMASK, &no_signals, nullptr) == 0 && ::prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 &&
      ::getppid() == supervisor && ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && null >= 0 &&
      ::dup2(null, 0) == 0 && ::dup2(start.out, 1) == 1 && ::dup2(start.err, 2) == 2 &&
      ::chdir(start.home) == 0 && confinement.leave_files() && confinement.hold_program() &&
      limit(RLIMIT_CORE, 0, 0) && limit(RLIMIT_CPU, limits.cpu_seconds, limits.cpu_seconds + 5) &&
      limit(RLIMIT_FSIZE, limits.file_size, limits.file_size) &&
      limit(RLIMIT_NOFILE, limits.open_files, limits.open_files) && limit(RLIMIT_NPROC, tasks, tasks) &&
      (limits.address_space == 0 || limit(RLIMIT_AS, limits.address_space, limits.address_space)) &&
      confinement.leave_calls();
  if (ready) confinement.execute(start.argv, start.envp);
  ::_exit(cannot_confine);
}

volatile pid_t supervised = 0;  // of the supervisor
void end_program(int) {
  if (supervised > 0) ::kill(supervised, SIGKILL);
}

// Kills the children of this process, and the orphans that it inherits from them, until none is left.
void end_descendants() {
  for (;;) {
    const pid_t reaped = ::waitpid(-1, nullptr, WNOHANG);
    if (reaped > 0) continue;
    if (reaped < 0 && errno != EINTR) return;
    const int list = ::open("/proc/thread-self/children", O_RDONLY | O_CLOEXEC);
    if (list < 0) return;
    char text[4096];
    const ssize_t size = ::read(list, text, sizeof text);
    ::close(list);
    pid_t number = 0;
    for (ssize_t i = 0; i < size; ++i) {  // "123 456 ", perhaps cut: the rest is in the next list
      if (text[i] == ' ' && number > 0) ::kill(number, SIGKILL);
      number = text[i] == ' ' ? 0 : 10 * number + (text[i] - '0');
    }
    ::poll(nullptr, 0, 1);
  }
}

// The supervisor: the process between the worker and the program. In a PID namespace it is the first process, so the
// kernel ends all others with it. Elsewhere it inherits the orphans and ends them itself. Then it reports how the
// program ended.
[[noreturn]] void supervise(const Start& start) {
  const bool first = start.confinement.namespaces() != 0;
  // The signals that the worker sends to end everything, and the one that this process gets when the worker has exited.
  const int end_all = first ? SIGKILL : SIGUSR1;
  ::close(start.worker_listens);
  for (const int number : {SIGPIPE, SIGTERM, SIGINT, SIGHUP})
    ::signal(number, SIG_IGN);  // they are for the program
  ::signal(SIGCHLD, SIG_DFL);
  sigset_t until_it_runs;
  ::sigemptyset(&until_it_runs);
  ::sigaddset(&until_it_runs, SIGUSR1);
  ::sigprocmask(SIG_SETMASK, &until_it_runs, nullptr);
  ::signal(SIGUSR1, end_program);
  pollfd worker{start.ended, 0, 0};
  const bool ready = (start.group < 0 || ::write(start.group, "0", 1) == 1) && ::setpgid(0, 0) == 0 &&
                     ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) == 0 &&
                     ::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0 &&
                     ::prctl(PR_SET_PDEATHSIG, end_all) == 0 &&
                     ::poll(&worker, 1, 0) == 0;  // otherwise the worker has already exited
  const pid_t self = ::getpid();
  supervised = ready ? fork_process(first, 0) : -1;
  if (supervised < 0) ::_exit(cannot_confine);
  if (supervised == 0) exec_program(start, self);
  ::dup2(start.ended, 0);
  ::close_range(1, ~0u, 0);
  ::sigprocmask(SIG_UNBLOCK, &until_it_runs, nullptr);
  int status = 0;
  for (;;) {
    const pid_t reaped = ::waitpid(-1, &status, 0);
    if (reaped == supervised) break;
    if (reaped < 0 && errno != EINTR) ::_exit(cannot_confine);
  }
  supervised = 0;
  (void)!::write(0, &status, sizeof status);
  if (!first) end_descendants();
  ::_exit(0);
}

// Splits a stream into lines. Drops lines that are too long.
class Lines {
 public:
  template <class F>
  void add(std::string_view bytes, const F& line) {
    for (const char c : bytes) {
      if (c == '\n') {
        if (!dropped_) line(std::string_view(text_));
        text_.clear();
        dropped_ = false;
      } else if (text_.size() < longest_line) {
        text_ += c;
      } else {
        dropped_ = true;
      }
    }
  }

 private:
  std::string text_;
  bool dropped_ = false;
};

// Reads what is there; false at the end of the stream.
bool take(int fd, std::string& into) {
  std::array<char, 16384> buffer;
  const ssize_t n = ::read(fd, buffer.data(), buffer.size());
  if (n > 0) into.assign(buffer.data(), static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR));
}

Error ran_out(const std::string& what) {
  return {Code::out_of_time, what, "",
          "give a smaller scan, a coarser sheet.resolution_mm or a lower print.dpi"};
}

}  // namespace

ChildLine parse_child_line(std::string_view line) {
  const auto object = nlohmann::json::parse(line, nullptr, false);
  if (!object.is_object()) return {};
  const auto text = [](const nlohmann::json& from, const char* key) {
    return printable(cut(text_of(from, key)));
  };
  if (const auto problem = object.find("problem"); problem != object.end()) {
    if (!problem->is_object()) return {};
    const auto code = code_from(text(*problem, "code"));
    if (!code || text(*problem, "what").empty()) return {};
    Error error{*code, text(*problem, "what"), text(*problem, "where"), text(*problem, "fix")};
    if (const auto list = problem->find("proposals"); list != problem->end())
      error.proposals = proposals_from(*list).value_or(std::vector<Proposal>());
    return error;
  }
  const auto stage = stage_from(text(object, "stage"));
  const auto progress = object.find("progress");
  if (!stage || progress == object.end() || !progress->is_number()) return {};
  const double fraction = progress->get<double>();
  if (!(fraction >= 0 && fraction <= 1)) return {};
  const auto cached = object.find("cached");
  return ChildProgress{*stage, fraction, cached != object.end() && *cached == nlohmann::json(true)};
}

Result<ChildEnd> run_child(const ChildCommand& command,
                           const std::function<void(const ChildProgress&)>& progress,
                           const std::function<bool()>& stop) {
  const ChildLimits& limits = command.limits;
  std::vector<char*> argv, envp;
  for (const std::string& word : command.words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const std::array<std::string, 3> environment{
      "PATH=/usr/local/bin:/usr/bin:/bin", "LANG=C.UTF-8",
      "HOME=" + std::filesystem::absolute(command.home).lexically_normal().string()};
  for (const std::string& variable : environment) envp.push_back(const_cast<char*>(variable.c_str()));
  envp.push_back(nullptr);

  VACUFORM_TRY(confinement,
               Confinement::prepare(command.sandbox, command.program_file, command.home, command.cache));
  std::optional<JobGroup> group;
  if (command.groups) {
    VACUFORM_TRY(made, command.groups->make(limits.address_space, limits.tasks));
    group.emplace(std::move(made));
  }
  Pipe out, err, ended;
  const Error no_process{Code::internal, "no process could be made for the job", "", "try again later"};
  if (!out.open() || !err.open() || !ended.open()) return tl::make_unexpected(no_process);
  const Start start{
      argv.data(), envp.data(), command.home.c_str(), limits,    confinement, group ? group->processes() : -1,
      out.write,   err.write,   ended.write,          ended.read};
  const bool namespaces = confinement.namespaces() != 0;
  const pid_t pid = fork_process(namespaces, confinement.namespaces());
  if (pid < 0) return tl::make_unexpected(no_process);
  if (pid == 0) supervise(start);
  ::setpgid(pid, pid);  // in parent and child: the order does not matter
  out.close_write();
  err.close_write();
  ended.close_write();
  ::fcntl(out.read, F_SETFL, O_NONBLOCK);
  ::fcntl(err.read, F_SETFL, O_NONBLOCK);

  ChildEnd end;
  Lines lines;
  const auto heard = [&](std::string_view line) {
    const ChildLine parsed = parse_child_line(line);
    if (const auto* step = std::get_if<ChildProgress>(&parsed)) progress(*step);
    if (const auto* error = std::get_if<Error>(&parsed)) end.problem = *error;
  };
  const auto listen = [&] {
    std::string bytes;
    if (out.read >= 0 && !take(out.read, bytes)) out.close_read();
    lines.add(bytes, heard);
    bytes.clear();
    if (err.read >= 0 && !take(err.read, bytes)) err.close_read();
    end.stderr_tail += bytes;
    if (end.stderr_tail.size() > 2 * stderr_limit)
      end.stderr_tail.erase(0, end.stderr_tail.size() - stderr_limit);
  };

  const auto started = steady_clock::now();
  std::optional<steady_clock::time_point> asked_to_end;
  bool killed = false, out_of_wall = false;
  for (;;) {
    siginfo_t info{};
    if (::waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        info.si_pid == pid)
      break;
    const auto now = steady_clock::now();
    if (!asked_to_end) {
      const bool stopped = stop();
      out_of_wall = !stopped && now - started > limits.wall;
      if (stopped || out_of_wall) {
        asked_to_end = now;
        end.how = stopped ? ChildEnd::How::stopped : ChildEnd::How::out_of_time;
        ::kill(-pid, SIGTERM);
      }
    } else if (!killed && now - *asked_to_end > grace) {
      killed = true;
      ::kill(pid, namespaces ? SIGKILL : SIGUSR1);
    }
    pollfd fds[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};  // poll skips an fd of -1
    ::poll(fds, 2, 50);
    listen();
  }
  int status = 0, supervisor_status = 0;
  ::waitpid(pid, &supervisor_status, 0);
  if (::read(ended.read, &status, sizeof status) != static_cast<ssize_t>(sizeof status))
    status = supervisor_status;  // the supervisor was killed, or could not start the program
  // What is still in the pipes, which hold 64 KiB each.
  for (int i = 0; i < 64 && (out.read >= 0 || err.read >= 0); ++i) {
    pollfd fds[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};
    if (::poll(fds, 2, 0) <= 0) break;
    listen();
  }
  if (end.stderr_tail.size() > stderr_limit) end.stderr_tail.erase(0, end.stderr_tail.size() - stderr_limit);

  end.out_of_memory = group && group->ran_out_of_memory();
  if (end.how == ChildEnd::How::stopped) return end;
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (out_of_wall) {
    end.problem =
        ran_out("the job took longer than " +
                std::to_string(std::chrono::duration_cast<std::chrono::seconds>(limits.wall).count()) + " s");
  } else if (signal == SIGXCPU) {
    end.how = ChildEnd::How::out_of_time;
    end.problem =
        ran_out("the job took more than " + std::to_string(limits.cpu_seconds) + " s of processor time");
  } else if (signal == SIGXFSZ) {
    end.how = ChildEnd::How::out_of_time;
    end.problem = ran_out("the job wrote a file larger than " + std::to_string(limits.file_size) + " bytes");
  } else {
    end.how = signal ? ChildEnd::How::signalled : ChildEnd::How::exited;
    end.number = signal ? signal : WEXITSTATUS(status);
  }
  return end;
}

Sandbox strongest_sandbox(int program_file, const std::string& program, const std::filesystem::path& home,
                          const ChildLimits& limits) {
  const Sandbox all = Sandbox::all();
  // From the strongest down: files and system calls matter more than namespaces, which seccomp also covers.
  const std::array choices{all,
                           Sandbox{false, all.landlock, true},
                           Sandbox{true, 0, true},
                           Sandbox{false, 0, true},
                           Sandbox{true, all.landlock, false},
                           Sandbox{false, all.landlock, false},
                           Sandbox{true, 0, false}};
  for (const Sandbox& choice : choices) {
    const auto end = run_child(
        {program_file, {program, "--version"}, home, limits, choice}, [](const ChildProgress&) {},
        [] { return false; });
    if (end && end->how == ChildEnd::How::exited && end->number == 0) return choice;
  }
  return {};
}

}  // namespace vacuform
