// Jobs as their users see them: submitted, listed, watched, cancelled and deleted. leases.hpp has what workers do with
// them; store.hpp the promises.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/job.hpp"
#include "server/store/scans.hpp"

namespace vacuform {

// Which jobs a list contains: those that meet every condition that is set.
struct JobFilter {
  std::optional<std::string> owner = {};
  std::vector<JobState> states = {};  // any of these; empty: all
  std::optional<JobKind> kind = {};
  std::optional<Millis> created_after = {}, created_before = {};  // neither includes the time itself
  std::string text = {};  // UTF-8, part of the reference, the note or the id, in any case; empty: all
};

// How much of a job a list contains: brief omits settings, inputs and artifacts, which are most of the work.
enum class Detail { brief, full };

struct JobPage {
  std::vector<Job> jobs;            // newest first
  std::optional<std::string> next;  // cursor of the page after this one
};

using JobGuard = std::function<bool(const Job& now)>;  // may be called twice

using JobCounts = std::array<std::int64_t, job_state_names.size()>;

// What a person who waits for a job wants to know. Both are estimates.
struct Estimate {
  // 1: the next; of a queued job. As the queue is now: later jobs, rests after faults, and jobs that end meanwhile change
  // it.
  std::optional<std::int64_t> queue_position;
  // From the start of the job to its end, by the last jobs of its kind; none if it has ended, or none has succeeded yet.
  std::optional<double> seconds_expected;
};

inline constexpr int most_searched = 2000;  // jobs

class JobTable {
 public:
  virtual ~JobTable() = default;
  // If a job was created under the same client key, that job is returned and no second one is created; conflict if that
  // key came with other files or settings. busy: the queue is full. gone: no row names a blob any more that the job
  // would share. `repeated`, if given, tells which of the two happened. Errors of
  // check_reference(), unless the job is a rescan.
  virtual Result<Job> create(NewJob job, bool* repeated = nullptr) = 0;
  // The time until the queue can accept this owner's next job after create() returned busy, from the rate at which jobs
  // ended within the last quarter of an hour: 1 to 600 seconds, and 60 if too few have ended for an estimate.
  virtual Result<std::int64_t> seconds_until_room(const std::string& owner) = 0;
  virtual Result<Job> job(const std::string& id) = 0;
  // Whether a job with this scan may have the reference: a reference belongs to one head. Jobs of the owner that are queued,
  // running or have succeeded count, except the job `but`. If such jobs have the reference and none of them has this scan, the
  // error is conflict, at "reference". An empty reference is free.
  virtual Result<void> check_reference(const std::string& owner, const std::string& reference,
                                       const std::string& scan_sha256, const std::string& but = {}) = 0;
  // Gives a job another reference and records who changed it, when, and both texts. The same text changes nothing. `allowed`
  // as for cancel(). Errors: not_found; conflict as in check_reference() unless it is a rescan, if `allowed` refused, or after
  // most_reference_changes.
  virtual Result<Job> set_reference(const std::string& id, const NewReference& reference,
                                    const JobGuard& allowed = {}) = 0;
  // Of the job as the store gave it.
  virtual Result<Estimate> estimate(const Job& job) = 0;
  // `limit` jobs (1 to 100) older than the job that the cursor names; an empty cursor starts with the newest. A filter
  // by text looks at most_searched jobs for a page, which may therefore have fewer jobs and still a `next`.
  virtual Result<JobPage> list(int limit, const std::string& cursor, const JobFilter& filter = {},
                               Detail detail = Detail::full) = 0;
  // The owner's newest inspection of these bytes with that extension, or nullopt.
  virtual Result<std::optional<Job>> newest_inspection(const StoredScan& scan) = 0;
  // A queued job is cancelled at once, a running one when its worker reports it; a cancelled one stays cancelled.
  // `allowed`, if given, gets the job in its state at the change, and may refuse with false; the same applies to
  // remove(). Errors: not_found; conflict if it has succeeded or failed, or `allowed` refused.
  virtual Result<Job> cancel(const std::string& id, const JobGuard& allowed = {}) = 0;
  // Errors: not_found; conflict unless the job has ended, or if the guard refused.
  virtual Result<void> remove(const std::string& id, const JobGuard& allowed = {}) = 0;
  // Lines of the job's log after the given number, at most `limit` (1 to 1000). Errors: not_found.
  virtual Result<std::vector<LogLine>> log_after(const std::string& id, std::int64_t number, int limit) = 0;
  // Returns the job as soon as its version is greater than the given one, or unchanged when the time is over. Errors:
  // not_found, also if it is deleted meanwhile; busy: most_waiters are waiting already.
  virtual Result<Job> wait_for_change(const std::string& id, std::int64_t version,
                                      std::chrono::milliseconds time) = 0;
  // Whether a job of this owner has the scan.
  virtual Result<bool> names_scan(const std::string& owner, const std::string& sha256) = 0;
  // The owner and scan of every job, each pair once.
  virtual Result<std::vector<std::pair<std::string, std::string>>> scans_of_jobs() = 0;
};

}  // namespace vacuform
