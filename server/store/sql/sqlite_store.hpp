// The store on SQLite. One process and one connection own the database: SQLite before 3.51.3 can lose committed rows in
// WAL mode if one connection checkpoints while another writes. A file lock stops a second server with a clear message;
// exclusive locking stops every other program.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/store/sql/sql_store.hpp"
#include "server/store/sqlite/group_commit.hpp"
#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

class SqliteStore : public SqlStore {
 public:
  SqliteStore(StoreOptions options, std::shared_ptr<DiskRoom> room, std::unique_ptr<BlobStore> blobs,
              File lock)
      : SqlStore(std::move(options), std::move(room), std::move(blobs), std::chrono::hours(1)),
        lock_(std::move(lock)) {}
  Result<void> open(const std::filesystem::path& data);
  std::int64_t steps() const { return db_.steps(); }  // for tests, while nothing else runs

 protected:
  Result<void> read_rows(const Look& look) override;
  Result<void> transaction(const Change& change) override;
  bool settled() const override { return !doubtful_; }
  LeaseTimes& lease_times() override { return leases_; }
  Result<std::optional<std::string>> next_queued(Database& db) override;
  std::int64_t schema_version() const override;
  // SQLite's backup API copies while the store is in use.
  Result<void> copy_rows(const std::filesystem::path& file, const std::function<bool()>& going) override;
  Result<std::string> page_fault(const std::function<bool()>& going) override;
  void forget_deleted() override;

 private:
  // In memory, by the time since the machine started: a heartbeat writes nothing.
  class Leases : public LeaseTimes {
   public:
    explicit Leases(const StoreOptions& options) : options_(options) {}
    // Jobs that were running when the last server ended keep their leases for another `lease`.
    Result<void> open(Database& db);
    Result<void> renew(Database& db, const std::string& job) override;
    Result<void> end(Database& db, const std::string& job) override;
    // The change may be undone: over() gives the job again, and then it is forgotten.
    Result<void> ended(Database&, const std::string&) override { return {}; }
    Result<void> forget(Database& db, const std::string& job) override;
    // A worker's call must not wait for the transaction under way before it joins the next.
    bool surely_none_over() const override { return all_over().empty(); }
    Result<std::vector<std::string>> over(Database&, bool) override { return all_over(); }
    Result<std::vector<Current>> current(Database& db) override;
    // The wall clock at the time when the store was opened, plus the time elapsed since.
    Result<Millis> now(Database&) override { return opened_ + options_.elapsed() - opened_elapsed_; }

   private:
    std::vector<std::string> all_over() const;
    void set(const std::string& job, std::optional<Millis> ends);  // none: forgotten

    const StoreOptions& options_;
    Millis opened_ = 0, opened_elapsed_ = 0;
    mutable std::mutex mutex_;
    std::map<std::string, Millis> ends_;               // by job; also for some jobs without a lease
    std::set<std::pair<Millis, std::string>> by_end_;  // the same
  };

  Result<void> open_rows(const std::filesystem::path& data);
  void transaction_ended(bool committed);
  void make_room();

  File lock_;  // released last
  // Everything below is only used under commits_.lock().
  SqliteDatabase db_;
  GroupCommit commits_{db_, [this] { make_room(); }, [this](bool done) { transaction_ended(done); }};
  Leases leases_{options_};
  // A commit has failed, so its rows may still be in SQLite's log and reappear after a crash. Blobs stay until another
  // commit has overwritten them there.
  bool doubtful_ = false;
  std::int64_t commits_before_doubt_ = 0;
};

}  // namespace vacuform
