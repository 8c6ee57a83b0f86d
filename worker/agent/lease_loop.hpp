// The worker's life: lease a job over HTTP, run it in a child, hand in its artifacts, and again.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "api/base/file_tree.hpp"
#include "api/client/client.hpp"
#include "worker/agent/child.hpp"
#include "worker/agent/kept_scans.hpp"
#include "worker/agent/stop_signal.hpp"

namespace vacuform {

struct LeaseLoop {
  std::string server, token, name;   // name: how this worker appears in the server's log
  std::filesystem::path work = ".";  // a folder of this user's own, for the jobs' private folders
  std::filesystem::path program;     // `vacuform`, by its name
  Descriptor program_file;           // and open, for jobs' processes: a new version on disk changes nothing
  std::chrono::milliseconds poll{1000};  // between two questions for a job
  ChildLimits limits;
  Sandbox sandbox;
  std::optional<KeptScans> kept;  // where jobs of the same scan find its formed sheet; none: nowhere

  // Until `stop` says so: the running child is then ended and its job released. A server that is away is asked again, with
  // a pause that grows to 10 s. A job that this program does not understand is released, and the loop ends. Errors:
  // unauthorized or forbidden (the server does not take the token), conflict (it speaks another protocol), bad_usage (the
  // address is no address; a job is not understood), unreadable (the folder for work).
  Result<void> run(const StopSignal& stop) const;
};

}  // namespace vacuform
