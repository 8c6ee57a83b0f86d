// Jobs as workers see them: leased, renewed and ended. transitions.hpp decides what each call makes of a job.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "api/retry.hpp"
#include "server/store/job.hpp"

namespace vacuform {

// What a worker sends with every write.
struct LeaseKey {
  std::string job, token;
};

struct LeasedJob {
  Job job;
  std::string token;  // 64 hexadecimal digits; the store keeps only its hash
};

// A job whose lease ran out, for the log.
struct Expired {
  std::string job;
  JobState state;  // queued, failed or cancelled
};

inline constexpr int most_log_lines = 500, longest_log_line = 200;

class LeaseTable {
 public:
  virtual ~LeaseTable() = default;
  // The next job of the queue, or nullopt. Also nullopt while the disk has no space for a job's artifacts.
  virtual Result<std::optional<LeasedJob>> lease(const std::string& worker) = 0;
  // The job under a current lease.
  virtual Result<Job> leased(const LeaseKey& key) = 0;
  // Renews the lease and records the progress; true if the job is being cancelled.
  virtual Result<bool> heartbeat(const LeaseKey& key, std::optional<Stage> stage, double progress) = 0;
  // Adds lines to the job's log. `first` is the number of the first one within this attempt, from 0: lines that were
  // stored before are skipped, so that a worker may repeat a request whose answer it never received. An attempt may
  // have most_log_lines, each cut to longest_log_line bytes; other characters than printable ASCII become '?'.
  virtual Result<void> log(const LeaseKey& key, int first, const std::vector<std::string>& lines) = 0;
  // A second file under the same name replaces the first.
  virtual Result<void> put_artifact(const LeaseKey& key, const std::string& name, Upload upload) = 0;
  // Ends the attempt: done (cancelled if a cancel came first; conflict if artifacts are missing), failed (queued again
  // depending on `retry` and the number of failures), cancelled, or released without an error. Returns the updated job.
  virtual Result<Job> complete(const LeaseKey& key, std::optional<int> serious_warnings = {}) = 0;
  virtual Result<Job> fail_job(const LeaseKey& key, const Error& error, Retry retry) = 0;
  virtual Result<Job> cancelled(const LeaseKey& key) = 0;
  virtual Result<Job> release(const LeaseKey& key) = 0;
  // Ends the leases that have expired. Every call of a worker does the same first.
  virtual Result<std::vector<Expired>> expire() = 0;
  // Ends at once the leases of a worker that is known to be dead, by the name that it used for them.
  virtual Result<std::vector<Expired>> end_leases_of(const std::string& worker) = 0;
};

}  // namespace vacuform
