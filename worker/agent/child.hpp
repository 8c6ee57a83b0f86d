// One run of the pipeline in a process of its own, with nothing to lose: `vacuform run` with hard limits, in a sandbox, with no
// inherited environment, no new privileges and no way to outlive its worker. What it writes is hostile until parsed.
//
// Between the worker and the program is a supervisor, a copy of the worker that executes nothing. With a namespace of
// processes it is the first process in it, and the kernel kills every other one when it ends. Without, it is the subreaper
// of everything that the program starts, and kills that until nothing is left.
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
#include "worker/agent/sandbox.hpp"

namespace vacuform {

// Hard limits of a child; passing one ends it.
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
  double fraction;    // of the stage, in [0, 1]
  bool kept = false;  // the stage was not run: its result was there already
};
using ChildLine = std::variant<std::monostate, ChildProgress, Error>;

// {"stage":"forming","progress":0.4}, with "kept":true where the stage was left out, or {"problem":{"code":"does-not-fit","what":...,"where":...,"fix":...}};
// anything else is nothing. Texts are cut to 2000 bytes.
ChildLine parse_child_line(std::string_view line);

struct ChildEnd {
  enum class How {
    exited,       // `number` is the exit status
    signalled,    // `number` is the signal
    out_of_time,  // a limit on time or on the size of a file ended it, as `problem` says
    stopped,      // `stop` asked for it
  };
  How how = How::exited;
  int number = 0;
  std::optional<Error> problem;  // the last that the child wrote, or that of the limit
  std::string last_words;        // the end of its standard error, at most 64 KiB
};

// Runs the program of the descriptor `program_file` (opened with O_PATH) as `command` (its name, then its arguments) to its
// end in the folder `home`, in its own process group, with stdin from /dev/null and only PATH, LANG and HOME in its
// environment, in the sandbox; a measure of it that fails ends the child with exit status 126. `kept` is a second folder that
// the sandbox lets the child use. `progress` is called for each progress line and `stop` at least every 0.1 s; when `stop`
// gives true the program gets SIGTERM and, half a second later, SIGKILL. Nothing that it started is left when this
// returns; without namespaces and without seccomp a program can end its supervisor, and then escape that. Call it from a
// thread that lives at least as long as the child: the kernel ends the child when that thread ends. Errors: internal (no
// process or sandbox could be made).
Result<ChildEnd> run_child(int program_file, const std::vector<std::string>& command,
                           const std::filesystem::path& home, const ChildLimits& limits,
                           const Sandbox& sandbox, const std::function<void(const ChildProgress&)>& progress,
                           const std::function<bool()>& stop, const std::filesystem::path& kept = {});

// The strongest choice of measures under which `program --version` ends well in `home`: they are tried together, with the
// program itself, as a job has them.
Sandbox strongest_sandbox(int program_file, const std::string& program, const std::filesystem::path& home,
                          const ChildLimits& limits);

}  // namespace vacuform
