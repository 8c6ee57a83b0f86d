// The store on a database that speaks SQL: everything but what differs between databases, which a derived class
// provides (sqlite_store.hpp). transitions.hpp decides what happens to jobs.
//
// sql_store.cpp keeps blobs and rows together, sql_jobs.cpp has the operations of users on jobs, sql_leases.cpp those of
// workers, sql_job_row.cpp the rows of both, sql_references.cpp
// whose a reference is, sql_status.cpp what administrators see, estimates.cpp estimates.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/store/blob_store.hpp"
#include "server/store/notifications.hpp"
#include "server/store/object_table.hpp"
#include "server/store/sql.hpp"
#include "server/store/sql/lease_times.hpp"
#include "server/store/store.hpp"
#include "server/store/transitions.hpp"

namespace vacuform {

class RowsFile;

class SqlStore : public Store, public ObjectTable {
 public:
  bool shared() const override { return !options_.database.empty() && blobs_->shared(); }
  Result<Upload> upload(Use use) override { return blobs_->upload(use); }
  Result<void> room_for(std::uint64_t bytes) override { return room_->check(Use::submission, bytes); }
  std::filesystem::path temporary_path() override { return blobs_->temporary_path(); }
  Result<std::unique_ptr<BlobReader>> open(const Blob& blob) override { return blobs_->open(blob.sha256); }
  Result<StoreStatus> status() override;
  Result<BackupReport> backup(const std::filesystem::path& to, const std::function<bool()>& going) override;
  Result<StoreCheck> check(bool read, const CheckGoing& going) override;
  Result<OrphanReport> orphans(const OrphanSearch& search, const std::function<bool()>& going) override {
    return blobs_->orphans(search, going);
  }

  Result<Job> create(NewJob job, bool* repeated = nullptr) override;
  Result<std::int64_t> seconds_until_room(const std::string& owner) override;
  Result<void> check_reference(const std::string& owner, const std::string& reference,
                               const std::string& scan_sha256, const std::string& but) override;
  Result<Job> set_reference(const std::string& id, const NewReference& reference,
                            const JobGuard& allowed) override;
  Result<Job> job(const std::string& id) override;
  Result<Estimate> estimate(const Job& job) override;
  Result<JobPage> list(int limit, const std::string& cursor, const JobFilter& filter, Detail detail) override;
  Result<std::optional<Job>> newest_inspection(const StoredScan& scan) override;
  Result<Job> cancel(const std::string& id, const JobGuard& allowed) override;
  Result<void> remove(const std::string& id, const JobGuard& allowed) override;
  Result<std::vector<LogLine>> log_after(const std::string& id, std::int64_t number, int limit) override;
  Result<Job> wait_for_change(const std::string& id, std::int64_t version,
                              std::chrono::milliseconds time) override;
  Result<bool> names_scan(const std::string& owner, const std::string& sha256) override;
  Result<std::vector<std::pair<std::string, std::string>>> scans_of_jobs() override;

  Result<void> add_token(const Token& token) override;
  Result<Token> token(const std::string& id) override;
  Result<std::vector<Token>> tokens() override;
  Result<void> revoke_token(const std::string& id) override;

  Result<void> add_session(const Session& session) override;
  Result<FoundSession> find_session(const std::string& hash) override;
  Result<void> end_session(const std::string& hash) override;
  Result<void> add_link(const SignInLink& link) override;
  Result<Token> use_link(const std::string& hash) override;

  Result<void> add_upload(const StoredUpload& upload) override;
  Result<StoredUpload> find_upload(const std::string& id) override;
  Result<StoredUpload> finish_upload(const std::string& id, Upload file) override;
  Result<void> remove_upload(const std::string& id) override;
  Result<void> add_piece(const std::string& id, int number, Upload piece, std::uint64_t received) override;
  Result<std::vector<Blob>> pieces(const std::string& id) override;
  Result<std::vector<std::string>> expire_uploads() override;

  Result<StoredScan> add_scan(const std::string& owner, std::variant<Upload, Blob> file,
                              const std::string& extension) override;
  Result<StoredScan> find_scan(const std::string& id) override;
  Result<ScanPage> list_scans(int limit, const std::string& cursor,
                              const std::optional<std::string>& owner) override;
  Result<void> remove_scan(const std::string& id) override;

  Result<bool> put_profile(const Profile& profile, const ProfileGuard& allowed) override;
  Result<Profile> find_profile(const std::string& name) override;
  Result<ProfilePage> list_profiles(int limit, const std::string& cursor) override;
  Result<void> remove_profile(const std::string& name, const ProfileGuard& allowed) override;
  Result<void> set_default_profile(const std::string& name, bool is_default) override;

  Result<std::optional<LeasedJob>> lease(const std::string& worker) override;
  Result<Job> leased(const LeaseKey& key) override;
  Result<bool> heartbeat(const LeaseKey& key, std::optional<Stage> stage, double progress) override;
  Result<void> log(const LeaseKey& key, int first, const std::vector<std::string>& lines) override;
  Result<void> put_artifact(const LeaseKey& key, const std::string& name, Upload upload) override;
  Result<Job> complete(const LeaseKey& key, std::optional<int> serious_warnings = {}) override {
    return finish(key, JobState::succeeded, {}, Retry::never, serious_warnings);
  }
  Result<Job> fail_job(const LeaseKey& key, const Error& error, Retry retry) override {
    return finish(key, JobState::failed, error, retry);
  }
  Result<Job> cancelled(const LeaseKey& key) override { return finish(key, JobState::cancelled); }
  Result<Job> release(const LeaseKey& key) override;
  Result<std::vector<Expired>> expire() override;
  Result<std::vector<Expired>> end_leases_of(const std::string& worker) override;

  // For copies of whole stores (copy_store.hpp).
  //
  // Copies all rows, as they are at one moment, into a new file of SQLite. `going` as for backup(); called when they are
  // copied, and for many rows before.
  virtual Result<void> copy_rows(const std::filesystem::path& file, const std::function<bool()>& going) = 0;
  // A table that has rows, other than those that match the store with its blobs. None: the store is empty.
  Result<std::optional<std::string>> table_with_rows();
  // Adds the rows of a file that copy_rows() wrote, in one change. Running jobs get leases that begin now. Errors: cancelled.
  Result<void> add_rows(RowsFile& from, const std::function<bool()>& going);
  // Makes the store empty.
  Result<void> remove_rows();
  BlobStore& blobs() { return *blobs_; }
  // Writes the rows of a job that cannot be read into a file of a folder, and removes them. Its blobs stay (repair.hpp).
  Result<void> set_job_in_quarantine(const std::string& id, const std::filesystem::path& folder);

 protected:
  using Look = std::function<Result<void>(Database&)>;
  using Change = std::function<bool(Database&)>;

  // `poll`: how long a waiter trusts that it is notified of changes.
  SqlStore(StoreOptions options, std::shared_ptr<DiskRoom> room, std::unique_ptr<BlobStore> blobs,
           std::chrono::milliseconds poll)
      : options_(std::move(options)),
        room_(std::move(room)),
        blobs_(std::move(blobs)),
        notifications_(options_.most_waiters, poll) {}

  // What differs between databases. From any thread; a function of the store never calls one within another.
  //
  // Calls `look` with a connection. Errors: those of `look`.
  virtual Result<void> read_rows(const Look& look) = 0;
  // Runs `change` in a transaction, and again when the database asks for it; returns when the change is on the disk.
  // False from `change` undoes it and is no error. An error undid the change, unless its text says that it may be made.
  virtual Result<void> transaction(const Change& change) = 0;
  // Within a look: whether every change that failed is undone for good. Until then no blob is deleted.
  virtual bool settled() const { return true; }
  virtual LeaseTimes& lease_times() = 0;
  // The id of the job whose turn it is (Store::lease()), locked.
  virtual Result<std::optional<std::string>> next_queued(Database& db) = 0;
  virtual std::int64_t schema_version() const = 0;  // of the tables
  // Adds to the status what the database alone knows.
  virtual Result<void> describe(Database&, StoreStatus&) { return {}; }
  // After a commit: tells other servers which jobs have changed.
  virtual void announce(const std::vector<std::string>&) {}

  // The first fault in the pages of the database; empty: none. `going` as for backup().
  virtual Result<std::string> page_fault(const std::function<bool()>&) { return std::string(); }
  // After a deletion: what was deleted is no longer in the database's files.
  virtual void forget_deleted() {}

  // Checks that the data folder belongs to the database, and binds those that are new to each other.
  Result<void> match_folder(const std::filesystem::path& data, const char* database);
  // Checks that the blobs are those of the rows, ends the deletions that a crash broke off, and sweeps. Before anything is
  // stored.
  Result<void> begin_blobs();
  // New ids come after those of jobs created up to then.
  void ids_after(Millis created) { last_id_time_ = std::max(created, last_id_time_.load()); }
  Notifications& notifications() { return notifications_; }

  const StoreOptions options_;
  const std::shared_ptr<DiskRoom> room_;

 private:
  // A change while it is made, and what follows from it once it has committed.
  struct Transaction {
    Database& db;
    std::vector<std::string> garbage = {};  // hashes of blobs that rows no longer name
    std::vector<std::string> changed = {};  // ids of jobs
    std::vector<Job> ended = {};
  };
  struct JobRow {
    Job job;
    std::vector<StoredArtifact> stored;  // artifacts so far; the job has them when it has ended
    Faults faults;
    std::string worker, lease_hash;
    std::int64_t log_lines = 0;  // of this attempt
  };

  // Runs `change(Transaction&)`, which gives a Result; an error of it undoes everything.
  template <class F>
  auto write(F change) -> decltype(change(std::declval<Transaction&>())) {
    decltype(change(std::declval<Transaction&>())) result =
        fail(Code::internal, "the store has an internal fault", {}, "try again");
    std::vector<std::string> garbage, changed;
    std::vector<Job> ended;
    const auto committed = transaction([&](Database& db) {
      Transaction tx{db};
      try {
        result = change(tx);
      } catch (const std::exception& fault) {  // a bug or out of memory: only this change fails
        result = fail(Code::internal, std::string("the store has an internal fault: ") + fault.what());
      }
      if (result)
        if (const auto pending = add_pending(db, tx.garbage); !pending)
          result = tl::make_unexpected(pending.error());
      garbage = std::move(tx.garbage), changed = std::move(tx.changed), ended = std::move(tx.ended);
      return result.has_value();
    });
    if (!committed) result = tl::make_unexpected(committed.error());
    if (result) follow(garbage, changed, ended);
    return result;
  }
  // Calls `look(Database&)`, which gives a Result.
  template <class F>
  auto read(F look) -> decltype(look(std::declval<Database&>())) {
    decltype(look(std::declval<Database&>())) result =
        fail(Code::internal, "the store has an internal fault");
    const auto looked = read_rows([&](Database& db) -> Result<void> {
      result = look(db);
      if (!result) return tl::make_unexpected(result.error());
      return {};
    });
    if (!looked) result = tl::make_unexpected(looked.error());
    return result;
  }
  void follow(const std::vector<std::string>& garbage, const std::vector<std::string>& changed,
              const std::vector<Job>& ended);

  // At the top of a function that may leave blobs to delete: they are deleted at its end.
  struct Deletion {
    explicit Deletion(SqlStore& s) : store(s) {}
    ~Deletion() { store.collect_garbage(); }
    Deletion(const Deletion&) = delete;
    SqlStore& store;
  };
  // Blobs stored before the rows that name them: if these do not commit, the blobs are garbage. If nobody knows whether
  // they have, the blobs stay; the next start deletes them if no row names them.
  struct Stored {
    explicit Stored(SqlStore& s) : store(s) {}
    ~Stored();
    Stored(const Stored&) = delete;
    // Stores an upload, or keeps the blob that the new row is to share. No transaction is open meanwhile.
    Result<Blob> add(std::variant<Upload, Blob>& file);
    SqlStore& store;
    std::vector<std::pair<Pin, std::string>> pins = {};
    template <class T>
    void written(const Result<T>& rows) {
      stay = rows || rows.error().code == Code::unavailable;
    }
    bool stay = false;
  };
  void add_garbage(const std::vector<std::string>& hashes);
  // Deletes the blobs of garbage_. The transaction that made them garbage has written them down as pending deletions, so
  // that the next start goes on with them.
  void collect_garbage();
  static Result<void> add_pending(Database& db, const std::vector<std::string>& hashes);
  // Whether the error is that of a row that cannot be read; such a row is logged and counted once.
  bool is_damage(const Error& error, const std::string& id);
  Result<bool> wanted(const std::string& sha256);  // whether a row names the blob, or it must stay for now
  static Result<bool> named(Database& db, const std::string& sha256);
  // The blobs of new inputs that older rows must name, since the inputs share them.
  class SharedBlobs {
   public:
    SharedBlobs(Database& db, std::span<const NewInput> inputs);
    // Errors: gone, if no row names one of them.
    Result<void> check();

   private:
    std::span<const NewInput> inputs_;
    Query unnamed_;
  };
  std::string next_id();

  // sql_job_row.cpp. With the lock, nobody else changes the job until the transaction has ended. Only a full job has inputs
  // and artifacts. Errors: not_found.
  enum class Lock { no, yes };
  static Result<JobRow> find_row(Database& db, const std::string& id, Lock lock, Detail detail);
  static Result<Job> find(Database& db, const std::string& id, Detail detail = Detail::full);
  // Writes all that changes about a job, with a greater version.
  static Result<void> save(Transaction& tx, JobRow& row);
  // Adds a line to the job's log, whose row is locked.
  Result<void> add_line(Database& db, const std::string& job, std::string_view text);
  // Makes a full job what the transition says, and saves it.
  Result<void> apply(Transaction& tx, JobRow& row, const Transition& next);
  static Result<void> drop_artifacts(Transaction& tx, JobRow& row, bool but_explaining = false);

  static Result<std::vector<std::string>> ids_of(Database& db, int count, const std::string& before,
                                                 const JobFilter& filter);
  static Result<bool> has_text(Database& db, const std::string& id, const std::u32string& folded_text);
  Result<JobCounts> counts(Database& db);
  static Result<std::int64_t> queue_position(Database& db, const Job& job);
  static Result<std::optional<double>> seconds_expected(Database& db, const Job& job);
  // The checks of create(), each with the query that finds its rows.
  static Result<std::optional<Job>> made_before(Database& db, Query& same_key, const NewJob& job,
                                                const std::vector<Blob>& blobs);
  Result<void> check_room(Query& waiting) const;
  static Result<void> claim_reference_of(Database& db, const NewJob& job, const std::vector<Blob>& blobs);
  static Result<Token> token_row(Database& db, const std::string& id);
  static Token token_in(const Query& row);  // id, owner, scopes, hash, created, expires, revoked, file
  Result<StoredUpload> upload_row(Database& db, const std::string& id);
  static Result<void> drop_pieces(Transaction& tx, const std::string& id);
  static Result<StoredScan> scan_row(Database& db, const std::string& id);
  static Result<Profile> profile_row(Database& db, const std::string& name);
  static Result<std::optional<Profile>> allowed_profile(Database& db, const std::string& name,
                                                        const ProfileGuard& allowed);

  // The job that the key's lease holds, locked. Ended jobs count only when `even_ended`.
  static Result<JobRow> holder(Database& db, const LeaseKey& key, Detail detail, bool even_ended = false);
  // As write(), after the leases that are over have been ended.
  template <class F>
  auto write_for_worker(F change) -> decltype(change(std::declval<Transaction&>())) {
    VACUFORM_CHECK(end_leases());
    return write(change);
  }
  Result<std::vector<Expired>> end_leases();

  // sql_objects.cpp
  Result<std::optional<StoredObject>> live_object(const std::string& sha256) override;
  Result<void> add_uploading(const StoredObject& object) override;
  Result<void> object_arrived(const StoredObject& object) override;
  Result<void> mark_for_deletion(const StoredObject& object) override;
  Result<void> mark_if_unnamed(const std::string& sha256) override;
  Result<void> mark_unnamed(Millis age) override;
  // In a transaction that begins to name blobs: until it ends, no server marks their objects. Errors: unavailable,
  // if one has.
  Result<void> hold_objects(Database& db, std::vector<std::string> hashes);
  Result<std::vector<StoredObject>> marked_until(Millis time, int limit) override;
  Result<void> forget(const StoredObject& object) override;
  Result<std::set<std::string>> keys_between(const std::string& first, const std::string& last) override;
  Result<Bucket> bucket() override;
  Result<void> remember_bucket(std::int64_t number) override;

  Result<Job> finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error = {},
                     Retry retry = Retry::never, std::optional<int> serious_warnings = {});
  RetryLimits limits() const { return {options_.losses, options_.crashes, options_.backoff}; }
  Result<void> remember(std::string_view event);  // that it happened now

  const std::unique_ptr<BlobStore> blobs_;
  Notifications notifications_;
  std::atomic<Millis> last_id_time_{0};
  std::mutex garbage_mutex_;
  std::vector<std::string> garbage_;
  int backups_ = 0;  // in progress; blobs stay until they are done
  std::mutex damage_mutex_;
  std::set<std::string> damaged_jobs_, damaged_files_;
  std::int64_t unnamed_files_ = 0, unnamed_bytes_ = 0;
};

// As open_store().
Result<std::unique_ptr<SqlStore>> open_sql_store(const std::filesystem::path& data, StoreOptions options);

// The lock of a data folder: one server at a time. Errors: unavailable (another server uses it), disk_full.
Result<File> lock_data_folder(const std::filesystem::path& data);

// The blobs of a data folder: in it, or in the object store that the options name.
Result<std::unique_ptr<BlobStore>> open_blobs(const std::filesystem::path& data, const StoreOptions& options,
                                              std::shared_ptr<const DiskRoom> room);

}  // namespace vacuform
