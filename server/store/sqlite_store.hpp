// The store on SQLite. One process and one connection own the database: SQLite before 3.51.3 can lose committed rows in
// WAL mode if one connection checkpoints while another writes. A file lock stops a second server with a clear message;
// exclusive locking stops every other program.
//
// sqlite_store.cpp opens it and stores the blobs, sqlite_jobs.cpp has the operations of users on jobs,
// sqlite_leases.cpp those of workers, sqlite_status.cpp what administrators see, sqlite_outlook.cpp
// estimates, sqlite_tokens.cpp the tokens, sqlite_backup.cpp the copy of everything.
#pragma once

#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/store/group_commit.hpp"
#include "server/store/news.hpp"
#include "server/store/sqlite.hpp"
#include "server/store/store.hpp"
#include "server/store/transitions.hpp"

namespace vacuform {

class SqliteStore : public Store {
 public:
  SqliteStore(StoreOptions options, std::shared_ptr<DiskRoom> room, std::unique_ptr<BlobStore> blobs,
              File lock)
      : options_(std::move(options)),
        lock_(std::move(lock)),
        room_(std::move(room)),
        blobs_(std::move(blobs)),
        news_(options_.most_waiters) {}
  Result<void> open(const std::filesystem::path& data);
  std::int64_t steps() const { return db_.steps(); }  // for tests, while nothing else runs

  Result<Upload> upload(Use use) override { return blobs_->upload(use); }
  Result<void> room_for(std::uint64_t bytes) override { return room_->check(Use::submission, bytes); }
  std::filesystem::path temporary_path() override { return blobs_->temporary_path(); }
  Result<std::unique_ptr<BlobReader>> open(const Blob& blob) override { return blobs_->open(blob.sha256); }
  Result<bool> names_scan(const std::string& owner, const std::string& sha256) override;
  Result<std::vector<std::pair<std::string, std::string>>> scans_of_jobs() override;
  Result<BackupReport> backup(const std::filesystem::path& to, const std::function<bool()>& going) override;

  Result<Job> create(NewJob job, bool* repeated = nullptr) override;
  Result<std::int64_t> seconds_until_room(const std::string& owner) override;
  Result<Job> job(const std::string& id) override;
  Result<Outlook> outlook(const Job& job) override;
  Result<JobPage> list(int limit, const std::string& cursor, const JobFilter& filter, Detail detail) override;
  Result<std::optional<Job>> newest_inspection(const StoredScan& scan) override;
  Result<JobCounts> counts() override;
  Result<StoreStatus> status() override;
  Result<Job> cancel(const std::string& id, const JobGuard& allowed) override;
  Result<void> remove(const std::string& id, const JobGuard& allowed) override;
  Result<std::vector<LogLine>> log_after(const std::string& id, std::int64_t number, int limit) override;
  Result<Job> wait_for_change(const std::string& id, std::int64_t version,
                              std::chrono::milliseconds time) override;

  Result<void> add_token(const Token& token) override;
  Result<Token> token(const std::string& id) override;
  Result<std::vector<Token>> tokens() override;
  Result<void> revoke_token(const std::string& id) override;

  Result<void> add_upload(const StoredUpload& upload) override;
  Result<StoredUpload> find_upload(const std::string& id) override;
  Result<StoredUpload> finish_upload(const std::string& id, Upload file) override;
  Result<void> remove_upload(const std::string& id) override;
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
  Result<std::vector<Expired>> bury(const std::string& worker) override;

 private:
  // Runs `change` in a transaction and returns when it is on the disk; an error of `change` rolls it back.
  template <class Change>
  auto write(Change change) -> decltype(change()) {
    decltype(change()) result = fail(Code::internal, "the store has an internal fault", {}, "try again");
    const auto committed = commits_.run([&] {
      const std::size_t ended_before = ended_jobs_.size();
      try {
        result = change();
      } catch (const std::exception& fault) {  // a bug or out of memory: only this change fails
        result = fail(Code::internal, std::string("the store has an internal fault: ") + fault.what());
      }
      if (!result) ended_jobs_.resize(ended_before);
      return result.has_value();
    });
    if (!committed) result = tl::make_unexpected(committed.error());
    return result;
  }

  // After the transaction, the blob is deleted unless a row names it by then.
  void maybe_garbage(const std::string& sha256) { garbage_.push_back(sha256); }
  void transaction_ended(bool committed);
  void make_room();
  // Deletes blobs without names. Not under the lock.
  void collect_garbage();
  // At the top of a function that may leave blobs to delete: they are deleted at its end.
  struct Deletion {
    explicit Deletion(SqliteStore& s) : store(s) {}
    ~Deletion() { store.collect_garbage(); }
    Deletion(const Deletion&) = delete;
    SqliteStore& store;
  };
  // Blobs stored before the rows that name them: if these do not commit, the blobs are garbage.
  struct Stored {
    explicit Stored(SqliteStore& s) : store(s) {}
    ~Stored();
    Stored(const Stored&) = delete;
    // Stores an upload, or keeps the blob that the new row is to share. No transaction is open meanwhile.
    Result<Blob> add(std::variant<Upload, Blob>& file);
    SqliteStore& store;
    std::vector<std::pair<Pin, std::string>> pins;
    bool named = false;  // the rows have committed
  };
  Result<bool> named(const std::string& sha256);   // whether any row names the blob
  Result<bool> wanted(const std::string& sha256);  // or must stay for now; takes the lock

  // The caller of all these holds the lock; those that change data are called inside write().
  Result<Job> find(const std::string& id, Detail detail = Detail::full);
  Result<std::vector<std::string>> ids_of(int count, const std::string& before, const JobFilter& filter);
  Result<JobCounts> counts_now();
  Result<std::int64_t> queue_position(const Job& job);
  Result<std::optional<double>> seconds_expected(const Job& job);
  Result<bool> has_text(const std::string& id, const std::u32string& folded_text);
  Result<Token> find_token(const std::string& id);
  Result<StoredUpload> upload_row(const std::string& id);
  Result<StoredScan> scan_row(const std::string& id);
  Result<Profile> profile_row(const std::string& name);
  Result<std::optional<Profile>> allowed_profile(const std::string& name, const ProfileGuard& allowed);
  // Errors: gone, if a blob that a new row is to share is named by no row.
  Result<void> check_shared(const NewInput& input);
  Result<std::optional<Job>> made_before(const NewJob& job, const std::vector<Blob>& blobs);
  Result<Job> holder(const LeaseKey& key, bool even_ended);
  Result<void> check_room(const std::string& owner);
  Result<std::optional<std::string>> next_queued();  // the id of the job whose turn it is
  Result<Job> finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error = {},
                     Retry retry = Retry::never, std::optional<int> serious_warnings = {});
  Result<void> apply(const Job& job, const Transition& next);
  Result<void> write_end(const Job& job, const Transition& next);
  Result<std::vector<StoredArtifact>> artifacts_of(const std::string& job);  // made so far, in no order
  // All, or all but those that explain a failure.
  Result<void> drop_artifacts(const Job& job, bool but_explaining = false);
  Result<Faults> faults_of(const std::string& job);
  RetryLimits limits() const { return {options_.losses, options_.crashes, options_.backoff}; }
  Result<std::vector<Expired>> expire_now();
  // The clock of rests: the wall clock at the time when the store was opened, plus the time elapsed since.
  Millis steady_now() const { return opened_ + options_.elapsed() - opened_elapsed_; }
  Result<void> remember_backup();  // that one is done now
  // Adds a line to the job's log, and notifies its waiters.
  Result<void> note(const std::string& job, std::string_view text);
  Result<void> tell(const std::string& job);  // notifies without a line

  StoreOptions options_;
  File lock_;  // released last
  std::shared_ptr<DiskRoom> room_;
  std::unique_ptr<BlobStore> blobs_;
  News news_;
  Millis opened_ = 0, opened_elapsed_ = 0;

  // Everything below is only used under commits_.lock().
  Database db_;
  GroupCommit commits_{db_, [this] { make_room(); }, [this](bool done) { transaction_ended(done); }};
  Millis last_id_time_ = 0;
  std::vector<std::string> garbage_, changed_;
  std::vector<Job> ended_jobs_;           // in this transaction
  std::map<std::string, Millis> leases_;  // when they end, by job; also for some jobs without a lease
  int backups_ = 0;                       // in progress; blobs stay until they are done
  // A commit has failed, so its rows may still be in SQLite's log and reappear after a crash. Blobs stay until another
  // commit has overwritten them there.
  bool doubtful_ = false;
  std::int64_t commits_before_doubt_ = 0;
};

}  // namespace vacuform
