// One run of the pipeline in a process of its own, with nothing to lose: `vacuform run` with hard limits, in a sandbox, with no
// inherited environment, no new privileges and no way to outlive its worker. What it writes is hostile until parsed.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/error.hpp"
#include "api/job.hpp"
#include "api/job_limits.hpp"
#include "worker/sandbox.hpp"

namespace vacuform {

// Hard limits of a child; passing one ends it.
struct ChildLimits {
  std::uint64_t address_space = job_limits.memory_bytes;  // bytes; 0: none (sanitizers reserve terabytes)
  std::uint64_t cpu_seconds = job_limits.cpu_seconds;
  std::uint64_t file_size = 4ull << 30;  // bytes, of each file
  std::uint64_t open_files = 64;
  std::chrono::milliseconds wall = std::chrono::seconds(job_limits.seconds);
};

// One line of the child's standard output (`vacuform run --progress json`).
struct ChildProgress {
  Stage stage;
  double fraction;    // of the stage, in [0, 1]
  bool kept = false;  // the stage was not run: its result was there already
};
using ChildLine = std::variant<std::monostate, ChildProgress, Error>;

// {"stage":"forming","progress":0.4}, with "kept":true where the stage was left out, or {"problem":{"code":"does-not-fit","what":...,"where":...,"mend":...}};
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

// Runs `command` (absolute program, arguments) to its end in the folder `home`, in its own process group, with stdin
// from /dev/null and only PATH, LANG and HOME in its environment, in the sandbox; a measure of it that fails ends the child
// with exit status 126. `progress` is called for each progress line and
// `stop` at least every 0.1 s; when `stop` gives true the group gets SIGTERM and, half a second later, SIGKILL. Nothing
// of the group is left when this returns. `kept` is a second folder that the sandbox lets the child use. Call it from a thread that lives at least as long as the child: the
// kernel kills the child when that thread ends. Errors: internal (no process or sandbox could be made).
Result<ChildEnd> run_child(const std::vector<std::string>& command, const std::filesystem::path& home,
                           const ChildLimits& limits, const Sandbox& sandbox,
                           const std::function<void(const ChildProgress&)>& progress,
                           const std::function<bool()>& stop, const std::filesystem::path& kept = {});

}  // namespace vacuform
