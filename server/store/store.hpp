// Jobs and their blobs, stored across crashes. The interface contains no SQL and no HTTP; sqlite_store.hpp implements
// it.
//
// Promises, all of them tested:
//  - What create() returned survives a power cut: the files are flushed before the row that names them commits, and the
//    row is flushed before create() returns.
//  - A job has at most one lease. Every write of a worker names the job and the lease's token; when the token is not
//    that of the current lease the write changes nothing and gives lease_lost. Ending a job twice under one token is
//    harmless and gives the same answer, so that a worker may repeat a request whose answer it never saw.
//  - A job shows its artifacts when it has succeeded, and it succeeds only with all artifacts that its kind always has.
//  - A full disk stops new files and submissions, not the rest: jobs can be deleted, cancelled and ended, and the store
//  - Leases and rests are spans of boot_clock(): setting the machine's clock neither ends nor extends them.
//  - A lease that is not renewed within `lease` ends, and the job is queued again. The same happens after faults that a
//    worker reports as its own. Neither is caused by the job: a machine restarts, a disk is full for a while. When
//    `losses` attempts were lost, which with the rests between them takes eight to twenty-five minutes, the job fails
//    with that reason, because it may be what brings the machine down. A job whose own process crashed `crashes` times
//    fails, and a job that was refused for its input is never tried again.
//  - After a fault the job rests: `backoff` the first time, twice as long each further time, at most ten minutes. A
//    random factor from 0.5 to 1.5 prevents that jobs which failed together return together.
//  - The queue is fair. Jobs that were raised above priority 0 go first: the highest priority, then the oldest. For the
//    others the owners take turns: the owner with the fewest running jobs, and of several the one that was served the
//    longest ago; of an owner's jobs the one with the highest priority, then the oldest.
//  - The queue is bounded: at most `most_queued` jobs wait, and at most `most_queued_by_owner` of one owner.
//  - A blob that open() returns has been read completely and checked against its hash since it was last written and
//    within the last hour.
//  - Files that no job names are deleted: with the job, or at the next start if a crash came between. A file that
//    cannot be deleted is logged and tried again.
// Every function may be called from any thread.
// Every function may be called from any thread.
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "api/retry.hpp"
#include "server/store/disk_room.hpp"
#include "server/store/job.hpp"
#include "server/store/profiles.hpp"
#include "server/store/scans.hpp"
#include "server/store/scopes.hpp"
#include "server/store/uploads.hpp"

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

// Access rights; see tokens.hpp.
struct Token {
  std::string id;     // 16 hexadecimal digits; no secret
  std::string owner;  // whose jobs it sees and makes
  Scopes scopes;
  std::string hash;  // SHA-256 of its secret, in hexadecimal
  Millis created = 0;
  std::optional<Millis> expires, revoked;
  std::string file = {};  // of the data folder, for which the server made it; empty: made on request
};

using JobGuard = std::function<bool(const Job& now)>;  // may be called twice

using JobCounts = std::array<std::int64_t, job_state_names.size()>;

// What a worker sends with every write.
struct LeaseKey {
  std::string job, token;
};

struct LeasedJob {
  Job job;
  std::string token;  // 64 hexadecimal digits; the store keeps only its hash
};

struct BackupReport {
  std::int64_t jobs = 0, blobs = 0;
  std::vector<std::string>
      damaged;  // hashes of blobs that were left out, since their bytes are no longer theirs
};

// What a person who waits for a job wants to know. Both are estimates.
struct Outlook {
  // 1: the next; of a queued job. As the queue is now: later jobs, rests after faults, and jobs that end meanwhile change
  // it.
  std::optional<std::int64_t> queue_position;
  // From the start of the job to its end, by the last jobs of its kind; none if it has ended, or none has succeeded yet.
  std::optional<double> seconds_expected;
};

// A worker that holds a job.
struct WorkingWorker {
  std::string name, job;
  Millis heard = 0;  // of its last heartbeat
};

// The state of the store, for administrators.
struct StoreStatus {
  std::int64_t schema = 0;  // version of the tables
  JobCounts counts{};
  std::optional<Millis> oldest_queued;  // when the job was created that waits the longest
  std::optional<Millis> last_backup;
  DiskSpace disk;
  std::vector<WorkingWorker> working;  // in the order of their jobs
};

// A job whose lease ran out, for the log.
struct Expired {
  std::string job;
  JobState state;  // queued, failed or cancelled
};

class Store : public UploadTable, public ScanTable, public ProfileTable {
 public:
  // Starts a file for create() or put_artifact(). Errors here and in every function that adds something: disk_full.
  virtual Result<Upload> upload(Use use = Use::submission) = 0;
  // Whether the disk has space for a submission of so many bytes. Errors: disk_full.
  virtual Result<void> room_for(std::uint64_t bytes) = 0;
  // A new name for a file of the caller; a file left there is deleted at the next start.
  virtual std::filesystem::path temporary_path() = 0;
  // If a job was created under the same client key, that job is returned and no second one is created; conflict if that
  // key came with other files or settings. busy: the queue is full. gone: no row names a blob any more that the job
  // would share. `repeated`, if given, tells which of the two happened.
  virtual Result<Job> create(NewJob job, bool* repeated = nullptr) = 0;
  // The time until the queue can accept this owner's next job after create() returned busy, from the rate at which jobs
  // ended within the last quarter of an hour: 1 to 600 seconds, and 60 if too few have ended for an estimate.
  virtual Result<std::int64_t> seconds_until_room(const std::string& owner) = 0;
  virtual Result<Job> job(const std::string& id) = 0;
  // Of the job as the store gave it.
  virtual Result<Outlook> outlook(const Job& job) = 0;
  // `limit` jobs (1 to 100) older than the job that the cursor names; an empty cursor starts with the newest. A filter
  // by text looks at most_searched jobs for a page, which may therefore have fewer jobs and still a `next`.
  virtual Result<JobPage> list(int limit, const std::string& cursor, const JobFilter& filter = {},
                               Detail detail = Detail::full) = 0;
  // The owner's newest inspection of these bytes with that extension, or nullopt.
  virtual Result<std::optional<Job>> newest_inspection(const StoredScan& scan) = 0;
  // The number of jobs in each state, by the state's number. A job whose lease has expired counts in its next state:
  // queued, or cancelled.
  virtual Result<JobCounts> counts() = 0;
  virtual Result<StoreStatus> status() = 0;
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
  // Opens a blob that a job names; it stays readable if the job is deleted meanwhile. Errors: not_found; gone: its
  // bytes have changed since they were stored, which is logged.
  virtual Result<File> open(const Blob& blob) = 0;

  // Whether a job of this owner has the scan.
  virtual Result<bool> names_scan(const std::string& owner, const std::string& sha256) = 0;
  // The owner and scan of every job, each pair once.
  virtual Result<std::vector<std::pair<std::string, std::string>>> scans_of_jobs() = 0;

  // Errors: conflict if the id exists.
  virtual Result<void> add_token(const Token& token) = 0;
  // Also returns an expired or revoked one. Errors: not_found.
  virtual Result<Token> token(const std::string& id) = 0;
  virtual Result<std::vector<Token>> tokens() = 0;  // oldest first
  // Permanent; revoking twice is harmless. Errors: not_found.
  virtual Result<void> revoke_token(const std::string& id) = 0;

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
  virtual Result<std::vector<Expired>> bury(const std::string& worker) = 0;

  // Copies everything into an empty folder while the store is in use: rows from one moment, blobs as hard links if the
  // disk is the same, each checked against its hash. open_store() opens the copy. `going` may cancel it. status() tells when it was done. Errors:
  // bad_usage (not an empty folder of this user), unavailable (disk full), cancelled.
  virtual Result<BackupReport> backup(const std::filesystem::path& to,
                                      const std::function<bool()>& going) = 0;
};

inline constexpr int most_searched = 2000;  // jobs
inline constexpr int most_log_lines = 500, longest_log_line = 200;

struct StoreOptions {
  Clock clock = wall_clock;    // for what is shown and kept
  Clock elapsed = boot_clock;  // for leases and rests
  std::optional<std::uint64_t> kept_free =
      {};  // bytes of the disk (disk_room.hpp); the default follows from the disk
  Millis lease = 30'000;
  int losses = 10;         // attempts that end with their worker, or by its fault
  int crashes = 2;         // of the job's own process
  Millis backoff = 2'000;  // the first rest of a job after a fault
  std::int64_t most_queued = 10'000, most_queued_by_owner = 1'000;
  // Called once for every job that has ended, by any thread, under the store's lock: it must be quick.
  std::function<void(const Job& job)> job_ended = {};
  std::size_t most_waiters = 256;  // threads in wait_for_change()
};

inline constexpr Millis longest_rest = 15 * 60'000;  // of a job after a fault

// Whether the folder contains a store, and the error for a folder that should.
bool has_store(const std::filesystem::path& data);
tl::unexpected<Error> no_store(const std::filesystem::path& data);

// Opens or creates the store in a folder; one process at a time (unavailable if another has it). Jobs that were running
// when the last server ended keep their leases for another `lease`, so that workers that are still running can
// continue. Errors: unavailable, corrupt_file (not a store, or written by a newer version).
Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options = {});

}  // namespace vacuform
