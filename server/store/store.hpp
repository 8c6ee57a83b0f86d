// Jobs and their blobs, stored across crashes. The interface contains no SQL and no HTTP; sql_store.hpp implements
// it. Its parts are in jobs.hpp, leases.hpp, tokens.hpp, sessions.hpp, profiles.hpp, scans.hpp and uploads.hpp.
//
// Promises, all of them tested:
//  - What create() returned survives a power cut: the files are flushed before the row that names them commits, and the
//    row is flushed before create() returns.
//  - A job has at most one lease. Every write of a worker names the job and the lease's token; when the token is not
//    that of the current lease the write changes nothing and gives lease_lost. Ending a job twice under one token is
//    harmless and gives the same answer, so that a worker may repeat a request whose answer it never saw.
//  - A job shows its artifacts when it has succeeded, and it succeeds only with all artifacts that its kind always has.
//  - A full disk stops new files and submissions, not the rest: jobs can be deleted, cancelled and ended, and the store
//    opens.
//  - Leases and rests are spans of boot_clock(), or of the clock of a database on another machine: setting the clock of
//    this machine neither ends nor extends them.
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
//  - Files of a deleted job are deleted with it, or at the next start if a crash came between. A file that cannot be
//    deleted is logged and tried again.
//  - No other file is ever deleted at once. A file that no row names and nobody asked to delete is a crash's, or one of
//    rows that were lost: a start moves few and old ones into quarantine, and leaves many or young ones where they are.
//    A database is used only with the data folder that it belongs to.
// Every function may be called from any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/disk_room.hpp"
#include "server/store/jobs.hpp"
#include "server/store/leases.hpp"
#include "server/store/orphans.hpp"
#include "server/store/profiles.hpp"
#include "server/store/scans.hpp"
#include "server/store/sessions.hpp"
#include "server/store/tokens.hpp"
#include "server/store/uploads.hpp"

namespace vacuform {

// What a check of the store found. "Damaged" is what is there and wrong or missing.
struct StoreCheck {
  std::string pages;  // the first fault in the pages of the database; empty: none
  std::int64_t jobs = 0, files = 0, bytes = 0;
  std::vector<std::string> damaged_jobs;   // ids of jobs whose rows cannot be read
  std::vector<std::string> missing_files;  // hashes of blobs that rows name
  std::vector<std::string> damaged_files;  // the same, whose bytes have another hash; only if they were read
  std::vector<std::string> unnamed;        // hashes of files in the data folder that no row names
  std::int64_t unnamed_bytes = 0;

  bool good() const {
    return pages.empty() && damaged_jobs.empty() && missing_files.empty() && damaged_files.empty();
  }
};

struct BackupReport {
  std::int64_t jobs = 0, blobs = 0;
  std::vector<std::string>
      damaged;  // hashes of blobs that were left out, since their bytes are no longer theirs
};

// A worker that holds a job.
struct WorkingWorker {
  std::string name, job;
  Millis heard = 0;  // of its last heartbeat
};

// The state of the store, for administrators.
struct StoreStatus {
  std::int64_t schema = 0;  // version of the tables
  // What an acknowledged change outlives: "local", a restart of the machine that keeps the rows; "synchronous", the loss
  // of that machine as well.
  std::string durability = "local";
  // Jobs in each state, by the state's number. A job whose lease has expired counts in its next state: queued, or cancelled.
  JobCounts counts{};
  std::optional<Millis> oldest_queued;  // when the job was created that waits the longest
  std::optional<Millis> last_backup, last_check;
  // Rows and files that were found damaged since the start, and files in the data folder that no row names.
  std::int64_t damaged_jobs = 0, damaged_files = 0, unnamed_files = 0, unnamed_bytes = 0;
  DiskSpace disk;
  std::vector<WorkingWorker> working;  // in the order of their jobs
  // In PostgreSQL: the age of the oldest transaction that keeps it from removing dead rows, of any client.
  std::optional<double> oldest_transaction_seconds;
};

// What a service keeps, by its parts. Code that needs one part takes a reference to that part.
class Store : public JobTable,
              public LeaseTable,
              public TokenTable,
              public SessionTable,
              public ProfileTable,
              public ScanTable,
              public UploadTable {
 public:
  // Whether several servers may use the store at the same time.
  virtual bool shared() const = 0;
  // Starts a file for create() or put_artifact(). Errors here and in every function that adds something: disk_full.
  virtual Result<Upload> upload(Use use = Use::submission) = 0;
  // Whether the disk has space for a submission of so many bytes. Errors: disk_full.
  virtual Result<void> room_for(std::uint64_t bytes) = 0;
  // A new name for a file of the caller; a file left there is deleted at the next start.
  virtual std::filesystem::path temporary_path() = 0;
  // Opens a blob that a job names; it stays readable if the job is deleted meanwhile. Errors: not_found; gone: its
  // bytes have changed since they were stored, which is logged.
  virtual Result<std::unique_ptr<BlobReader>> open(const Blob& blob) = 0;
  virtual Result<StoreStatus> status() = 0;
  // Copies everything into an empty folder while the store is in use: rows from one moment, blobs as hard links if the
  // disk is the same, each checked against its hash. open_store() opens the copy. `going` may cancel it. status() tells
  // when it was done. Errors: bad_usage (not an empty folder of this user), unavailable (disk full), cancelled.
  virtual Result<BackupReport> backup(const std::filesystem::path& to,
                                      const std::function<bool()>& going) = 0;
  // Looks at every page, every row and every file while the store is in use, and at the bytes of the files too if `read`.
  // Logs what it finds, for status(). `going` is told how many bytes were read since the last call, may take its time,
  // and may cancel. Errors: unavailable, cancelled.
  using CheckGoing = std::function<bool(std::uint64_t bytes)>;
  virtual Result<StoreCheck> check(bool read, const CheckGoing& going) = 0;
  // Finds the objects in the bucket that no row knows, and deletes them if that is wanted. `going` may cancel it. Errors:
  // bad_usage (the blobs are files), conflict (too many to delete), unavailable, cancelled.
  virtual Result<OrphanReport> orphans(const OrphanSearch& search, const std::function<bool()>& going) = 0;
};

struct StoreOptions {
  // "postgresql://user@host/database" keeps the rows there. Empty: in a file of SQLite in the data folder.
  std::string database = {};
  // "s3://bucket?endpoint=https://..." keeps the blobs there (s3_address.hpp). Empty or "file:": in the data folder.
  std::string blobs = {};
  std::filesystem::path blobs_credentials = {};  // the file with the access key; empty: the environment
  Clock clock = wall_clock;                      // for what is shown and kept
  // For leases and rests. None: boot_clock of this machine with SQLite, the clock of the database with PostgreSQL.
  Clock elapsed = {};
  std::optional<std::uint64_t> kept_free =
      {};  // bytes of the disk (disk_room.hpp); the default follows from the disk
  Millis lease = 30'000;
  int losses = 10;         // attempts that end with their worker, or by its fault
  int crashes = 2;         // of the job's own process
  Millis backoff = 2'000;  // the first rest of a job after a fault
  std::int64_t most_queued = 10'000, most_queued_by_owner = 1'000;
  // Called once for every job that has ended, after the commit, by any thread.
  std::function<void(const Job& job)> job_ended = {};
  std::size_t most_waiters = 256;  // threads in wait_for_change()
  // Binds the data folder and the database to each other, whatever they were bound to.
  bool adopt = false;
  int quarantine_days = 30;  // after which a file in quarantine is deleted
  // Asked by any thread during a request to an object store; false gives the request up with cancelled.
  std::function<bool()> going = {};
};

inline constexpr Millis longest_rest = 15 * 60'000;  // of a job after a fault

// Whether the folder contains a store, and the error for a folder that should.
bool has_store(const std::filesystem::path& data);
tl::unexpected<Error> no_store(const std::filesystem::path& data);

// Whether StoreOptions::database is empty or can be read, without a connection. It must not contain a password, which other
// users of the machine could see among the arguments of the server. Errors: bad_usage.
Result<void> check_database(const std::string& database);

// Opens or creates the store in a folder; one process at a time (unavailable if another has it). Leases end at the
// earliest a `lease` after that, so that workers which kept running while there was no server can continue. Errors:
// unavailable, corrupt_file (not a store, or written by a newer version), bad_usage (StoreOptions::database).
Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options = {});

}  // namespace vacuform
