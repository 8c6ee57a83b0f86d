// The lines that a worker adds to the log of a job on the server: only fixed texts and codes, nothing from a file.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/client/client.hpp"
#include "worker/agent/job_file.hpp"

namespace vacuform {

// Thread safe.
class JobLog {
 public:
  void say(std::string line);
  // Sends what the server has not confirmed; skips lines that the server already has. Errors: those of the call.
  Result<void> send(WorkerClient& client, const Lease& lease, const Going& going = {});

 private:
  std::mutex mutex_, sending_;
  std::vector<std::string> lines_;
  std::size_t sent_ = 0;
};

// The warnings in a report.json or findings.json. The child wrote the file, so it may contain anything.
struct ReportedWarnings {
  std::vector<std::string> codes;  // those that look like codes, at most 50
  std::optional<int> serious;      // how many of all; missing if the file is not a report
};
ReportedWarnings reported_warnings(const JobFile& report);

}  // namespace vacuform
