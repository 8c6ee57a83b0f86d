// The lines that a worker adds to the log of a job on the server: words of our own and codes, nothing out of a file.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "api/client.hpp"
#include "worker/job_file.hpp"

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

// The codes of the warnings in a report.json, which the child wrote and which may be anything; none when it is no report.
std::vector<std::string> warning_codes(const JobFile& report);

}  // namespace vacuform
