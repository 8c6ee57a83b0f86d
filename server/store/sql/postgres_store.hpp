// The store with its rows in PostgreSQL. With its blobs in an object store, several servers use it at the same time;
// otherwise the blobs are in the data folder of the one server.
//
// Transactions of different jobs run at the same time. A change locks the row of its job, so that the lines of its log
// are numbered without gaps; a lease skips rows that are locked. A transaction that meets another, or loses its
// connection before the commit, is tried again; one whose commit is not answered is not, and its caller repeats the
// request with the same token or idempotency key. Leases end by the clock of the database. After the server has opened
// the store, or could not reach the database, none ends for the time of a lease.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "server/store/postgres/postgres.hpp"
#include "server/store/postgres/postgres_notifications.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

class PostgresStore : public SqlStore {
 public:
  PostgresStore(StoreOptions options, std::shared_ptr<DiskRoom> room, std::unique_ptr<BlobStore> blobs,
                File lock);
  // Errors: unavailable; corrupt_file (tables of a newer version, or a data folder of another store).
  Result<void> open(const std::filesystem::path& data);
  // Whether it is notified of changes that other servers make; otherwise it looks every two seconds.
  bool hears() const { return announcements_ && announcements_->hears(); }

 protected:
  Result<void> read_rows(const Look& look) override;
  Result<void> transaction(const Change& change) override;
  LeaseTimes& lease_times() override { return leases_; }
  // Two workers that ask at the same moment see the same counts, and may get two jobs of one owner.
  Result<std::optional<std::string>> next_queued(Database& db) override;
  std::int64_t schema_version() const override;
  // "synchronous" when a standby confirms each commit.
  Result<void> describe(Database& db, StoreStatus& status) override;
  Result<void> copy_rows(const std::filesystem::path& file, const std::function<bool()>& going) override;
  void announce(const std::vector<std::string>& jobs) override { announcements_->send(jobs); }

 private:
  class Leases : public LeaseTimes {
   public:
    explicit Leases(const StoreOptions& options) : options_(options) {}
    void hold();  // no lease ends for the time of one
    Result<void> renew(Database& db, const std::string& job) override;
    Result<void> end(Database& db, const std::string& job) override;
    Result<void> ended(Database& db, const std::string& job) override { return forget(db, job); }
    Result<void> forget(Database& db, const std::string& job) override;
    // For a fifth of a second after the database said so: else every call of a worker would ask.
    bool surely_none_over() const override;
    Result<std::vector<std::string>> over(Database& db, bool lock) override;
    Result<std::vector<Current>> current(Database& db) override;
    Result<Millis> now(Database& db) override;
    // The time that a test sets; none: that of the database.
    std::optional<Millis> set_time() const;

   private:
    Millis elapsed() const { return options_.elapsed ? options_.elapsed() : boot_clock(); }

    const StoreOptions& options_;
    std::atomic<Millis> held_until_{0};
    std::atomic<Millis> none_until_{0};  // by elapsed()
  };
  enum class Outcome { done, refused, again };
  Result<Outcome> change_once(PostgresConnection& connection, const Change& change);

  File lock_;  // released last
  PostgresPool pool_;
  Leases leases_{options_};
  std::unique_ptr<PostgresNotifications> announcements_;  // ends before the pool
};

// As open_store(), with options.database set.
Result<std::unique_ptr<SqlStore>> open_postgres_store(const std::filesystem::path& data,
                                                      StoreOptions options);

}  // namespace vacuform
