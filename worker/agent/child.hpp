// One run of the pipeline in a separate process with nothing to lose: `vacuform run` with hard limits, in a sandbox,
// with no inherited environment, no new privileges and no way to outlive its worker. Its output is untrusted until
// parsed.
//
// A supervisor runs between the worker and the program. It is a copy of the worker that executes nothing. With a PID
// namespace it is the first process in it, and the kernel kills every other one when it ends. Without a namespace it is
// the subreaper of everything that the program starts, and kills it until nothing is left.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <variant>
#include <vector>

#include "api/base/error.hpp"
#include "api/job.hpp"
#include "api/job_limits.hpp"
#include "worker/agent/job_group.hpp"
#include "worker/agent/sandbox.hpp"

namespace vacuform {

// Hard limits of a child. A child that exceeds one is ended.
struct ChildLimits {
  std::uint64_t address_space = job_limits.memory_bytes;  // bytes; 0: none (sanitizers reserve terabytes)
  std::uint64_t cpu_seconds = job_limits.cpu_seconds;
  std::uint64_t file_size = 4ull << 30;  // bytes, of each file
  std::uint64_t open_files = 64;
  std::uint64_t tasks =
      128 + 8 * std::thread::hardware_concurrency();  // threads; the kernel holds root to none
  std::chrono::milliseconds wall = std::chrono::seconds(job_limits.seconds);
};

// One line of the child's standard output (`vacuform run --progress json`).
struct ChildProgress {
  Stage stage;
  double fraction;      // of the stage, in [0, 1]
  bool cached = false;  // the stage was not run: its result was already available
};
using ChildLine = std::variant<std::monostate, ChildProgress, Error>;

// {"stage":"forming","progress":0.4}, with "cached":true if the stage was skipped, or
// {"problem":{"code":"does-not-fit","what":...,"where":...,"fix":...,"proposals":[...]}}; any other line returns nothing.
// Texts are cut to 2000 bytes; proposals outside of proposal_limits are left out.
ChildLine parse_child_line(std::string_view line);

struct ChildEnd {
  enum class How {
    exited,       // `number` is the exit status
    signalled,    // `number` is the signal
    out_of_time,  // a limit on time or on the size of a file ended it, as `problem` says
    stopped,      // `stop` returned true
  };
  How how = How::exited;
  int number = 0;
  std::optional<Error> problem;  // the last that the child wrote, or that of the limit
  std::string stderr_tail;       // at most 64 KiB
  bool out_of_memory = false;    // the kernel killed it for the limit of its group
};

// What to run, where and within which limits.
struct ChildCommand {
  int program_file = -1;                // the program, opened with O_PATH
  std::vector<std::string> words = {};  // its name, then its arguments
  std::filesystem::path home;           // the folder in which it runs
  ChildLimits limits = {};
  Sandbox sandbox = {};
  std::filesystem::path cache = {};   // a second folder that it may use; may be empty
  const JobGroups* groups = nullptr;  // in which it gets a control group of its own; nullptr: none
};

// Runs `command` and waits for its end. The child has its own process group, stdin from /dev/null, only PATH, LANG and
// HOME in its environment, and the sandbox. If a sandbox measure fails, the child exits with status 126. `progress` is
// called for each progress line and `stop` at least every 0.1 s; when `stop` returns true the program gets SIGTERM and,
// half a second later, SIGKILL. No process that it started is left when this returns. Exception: without namespaces,
// without seccomp and without a control group a program can end its supervisor and then escape. Call this from a thread
// that lives at least as long as the child: the kernel ends the child when that thread ends. Errors: internal (the
// process, its group or the sandbox cannot be created).
Result<ChildEnd> run_child(const ChildCommand& command,
                           const std::function<void(const ChildProgress&)>& progress,
                           const std::function<bool()>& stop);

// The strongest set of measures under which `program --version` succeeds in `home`. They are tried together, with the
// program itself, as a job uses them.
Sandbox strongest_sandbox(int program_file, const std::string& program, const std::filesystem::path& home,
                          const ChildLimits& limits);

}  // namespace vacuform
