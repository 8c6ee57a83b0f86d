#include "worker/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace vacuform {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::size_t longest_line = 16u << 10;
constexpr std::size_t last_words_limit = 64u << 10;
constexpr std::size_t longest_text = 2000;
constexpr milliseconds grace{500};  // from SIGTERM to SIGKILL: stages look at their cancellation every 0.2 s

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

// Cuts a text that may be far too long without cutting a UTF-8 sequence.
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

// In the child, between fork and exec: only async-signal-safe calls. A step that fails ends it: no half sandbox.
[[noreturn]] void become(char* const* argv, char* const* envp, const char* home, const ChildLimits& limits,
                         const Confinement& confinement, int out, int err, pid_t parent) {
  constexpr int refused = 126;
  for (const int number : {SIGPIPE, SIGTERM, SIGINT, SIGHUP, SIGCHLD}) ::signal(number, SIG_DFL);
  sigset_t none;
  ::sigemptyset(&none);
  const int null = ::open("/dev/null", O_RDONLY);
  const bool ready =
      ::sigprocmask(SIG_SETMASK, &none, nullptr) == 0 && ::setpgid(0, 0) == 0 &&
      confinement.leave_namespaces() && ::prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 &&
      ::getppid() == parent &&  // else the worker is dead already
      ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && null >= 0 && ::dup2(null, 0) == 0 &&
      ::dup2(out, 1) == 1 && ::dup2(err, 2) == 2 && confinement.leave_files() &&
      ::close_range(3, ~0u, 0) == 0 && ::chdir(home) == 0 && limit(RLIMIT_CORE, 0, 0) &&
      limit(RLIMIT_CPU, limits.cpu_seconds, limits.cpu_seconds + 5) &&
      limit(RLIMIT_FSIZE, limits.file_size, limits.file_size) &&
      limit(RLIMIT_NOFILE, limits.open_files, limits.open_files) &&
      (limits.address_space == 0 || limit(RLIMIT_AS, limits.address_space, limits.address_space)) &&
      confinement.leave_calls();
  if (!ready) ::_exit(refused);
  ::execve(argv[0], argv, envp);
  ::_exit(refused);
}

// Splits a stream into lines; a line that is too long is dropped whole.
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
    const auto it = from.find(key);
    return it != from.end() && it->is_string() ? cut(it->get<std::string>()) : std::string();
  };
  if (const auto problem = object.find("problem"); problem != object.end()) {
    if (!problem->is_object()) return {};
    const auto code = code_from(text(*problem, "code"));
    if (!code || text(*problem, "what").empty()) return {};
    return Error{*code, text(*problem, "what"), text(*problem, "where"), text(*problem, "mend")};
  }
  const auto stage = stage_from(text(object, "stage"));
  const auto progress = object.find("progress");
  if (!stage || progress == object.end() || !progress->is_number()) return {};
  const double fraction = progress->get<double>();
  if (!(fraction >= 0 && fraction <= 1)) return {};
  const auto kept = object.find("kept");
  return ChildProgress{*stage, fraction, kept != object.end() && *kept == nlohmann::json(true)};
}

Result<ChildEnd> run_child(const std::vector<std::string>& command, const std::filesystem::path& home,
                           const ChildLimits& limits, const Sandbox& sandbox,
                           const std::function<void(const ChildProgress&)>& progress,
                           const std::function<bool()>& stop, const std::filesystem::path& kept) {
  std::vector<char*> argv, envp;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const std::array<std::string, 3> environment{"PATH=/usr/local/bin:/usr/bin:/bin", "LANG=C.UTF-8",
                                               "HOME=" + home.string()};
  for (const std::string& variable : environment) envp.push_back(const_cast<char*>(variable.c_str()));
  envp.push_back(nullptr);

  VACUFORM_TRY(confinement, Confinement::prepare(sandbox, argv[0], home, kept));
  Pipe out, err;
  const Error no_process{Code::internal, "no process could be made for the job", "", "try again later"};
  if (!out.open() || !err.open()) return tl::make_unexpected(no_process);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return tl::make_unexpected(no_process);
  if (pid == 0)
    become(argv.data(), envp.data(), home.c_str(), limits, confinement, out.write, err.write, parent);
  ::setpgid(pid, pid);  // whoever comes first
  out.close_write();
  err.close_write();
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
    end.last_words += bytes;
    if (end.last_words.size() > 2 * last_words_limit)
      end.last_words.erase(0, end.last_words.size() - last_words_limit);
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
      ::kill(-pid, SIGKILL);
    }
    pollfd fds[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};  // poll skips an fd of -1
    ::poll(fds, 2, 50);
    listen();
  }
  ::kill(-pid, SIGKILL);  // the rest of its group, while the unreaped leader keeps the group's number
  int status = 0;
  ::waitpid(pid, &status, 0);
  // What still stands in the pipes: bounded, since a process that left the group may hold them open.
  for (int i = 0; i < 64 && (out.read >= 0 || err.read >= 0); ++i) {
    pollfd fds[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};
    if (::poll(fds, 2, 0) <= 0) break;
    listen();
  }
  if (end.last_words.size() > last_words_limit)
    end.last_words.erase(0, end.last_words.size() - last_words_limit);

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

}  // namespace vacuform
