// The main loop of a worker: lease a job over HTTP, run it in a child, hand in its artifacts, repeat.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "api/base/file_tree.hpp"
#include "api/client/client.hpp"
#include "worker/agent/child.hpp"
#include "worker/agent/job_group.hpp"
#include "worker/agent/scan_caches.hpp"
#include "worker/agent/stop_signal.hpp"

namespace vacuform {

struct LeaseLoop {
  std::string server, token, name;   // name: how this worker appears in the server's log
  std::filesystem::path work = ".";  // a private folder of this user, for the folders of the jobs
  std::filesystem::path program;     // `vacuform`, by its name
  Descriptor program_file;           // open, for the processes of jobs: a new version on disk changes nothing
  std::chrono::milliseconds poll{1000};                // polling interval
  std::optional<int> most_jobs;                        // the loop ends after so many
  std::optional<std::chrono::milliseconds> idle_exit;  // and when the server has had no job for so long
  ChildLimits limits;
  Sandbox sandbox;
  std::optional<JobGroups> groups;   // control groups for jobs; absent where the system gives none
  std::optional<ScanCaches> caches;  // where jobs of the same scan find its formed sheet; may be absent

  // Runs until `stop`, most_jobs or idle_exit. After `stop` it leases no job; the running one goes on until the drain of
  // `stop` ends. Then its child is ended and it is released, which counts no attempt. A server that is away is retried,
  // with a pause that grows to 10 s. A job that this program does not understand is released, and the loop ends.
  // Errors: unauthorized or forbidden (the server rejects the token), conflict (it uses another protocol), bad_usage
  // (the address is invalid; a job is not understood), unreadable (the work folder).
  Result<void> run(const StopSignal& stop) const;
};

}  // namespace vacuform
