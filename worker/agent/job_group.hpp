// A control group (cgroup v2) for each job, where the system delegates a part of its tree to this worker, as systemd does
// for a unit with `Delegate=`. The kernel then counts all memory of a job, files in memory included, and its processes,
// and ends them together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "api/base/file_tree.hpp"

namespace vacuform {

// The group of one job. The destructor kills what is still in it and removes it.
class JobGroup {
 public:
  JobGroup(std::filesystem::path folder, Descriptor processes)
      : folder_(std::move(folder)), processes_(std::move(processes)) {}
  ~JobGroup();
  JobGroup(JobGroup&&) noexcept = default;
  JobGroup(const JobGroup&) = delete;
  JobGroup& operator=(const JobGroup&) = delete;

  // A process that writes "0" here, with all its later children, belongs to the group.
  int processes() const { return processes_.number(); }
  bool ran_out_of_memory() const;  // the kernel killed it for its limit of memory

 private:
  std::filesystem::path folder_;
  Descriptor processes_;
};

class JobGroups {
 public:
  // In the group of this process, if systemd has delegated it (the attribute `user.delegate`). Returns nothing elsewhere:
  // in a container, in a login session, on cgroup v1.
  static std::optional<JobGroups> delegated();
  // In the group `folder`, which this process may change. Moves this process to its subgroup `worker`, because processes
  // live in leaves only, and removes the groups of jobs that an earlier worker left. Errors: unreadable.
  static Result<JobGroups> in(const std::filesystem::path& folder);

  // A new group with limits on memory (bytes, without swap; 0: none) and on the number of processes and threads, as far
  // as the system has these `controllers`. Errors: internal.
  Result<JobGroup> make(std::uint64_t memory_bytes, std::uint64_t tasks) const;

  const std::vector<std::string>& controllers() const { return controllers_; }  // of "memory" and "pids"

 private:
  std::filesystem::path folder_;
  std::vector<std::string> controllers_;
};

}  // namespace vacuform
