// The lines that a worker adds to the log of a job on the server: words of our own and codes, nothing out of a file.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/client/client.hpp"
#include "worker/agent/job_file.hpp"

namespace vacuform {

// From any thread.
class JobLog {
 public:
  void say(std::string line);
  // Sends what the server has not confirmed; a line that it has heard already it leaves out. Errors: those of the call.
  Result<void> send(WorkerClient& client, const Lease& lease, const Going& going = {});

 private:
  std::mutex mutex_, sending_;
  std::vector<std::string> lines_;
  std::size_t sent_ = 0;
};

// The warnings in a report.json or findings.json, which the child wrote and which may be anything.
struct ReportedWarnings {
  std::vector<std::string> codes;  // those that look like codes, at most 50
  std::optional<int> serious;      // how many of all; none when it is no report
};
ReportedWarnings reported_warnings(const JobFile& report);

}  // namespace vacuform
