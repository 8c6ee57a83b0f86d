// When leases end, and the clock of rests: what a machine's wall clock must not decide. SQLite keeps them by the time
// since the machine started, PostgreSQL by the clock of the database.
#pragma once

#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "server/store/sql.hpp"

namespace vacuform {

// A function with `db` is called within a look at the rows, or a change of them; `db` is its connection.
class LeaseTimes {
 public:
  struct Current {
    std::string job;
    Millis heard = 0;  // wall clock of the last heartbeat
  };

  virtual ~LeaseTimes() = default;
  // The lease of a job begins now, or is renewed.
  virtual Result<void> renew(Database& db, const std::string& job) = 0;
  // Lets a lease end at once.
  virtual Result<void> end(Database& db, const std::string& job) = 0;
  // This change ends the lease, unless it is undone.
  virtual Result<void> ended(Database& db, const std::string& job) = 0;
  // The job has no lease.
  virtual Result<void> forget(Database& db, const std::string& job) = 0;
  // Whether over() would give no job, as far as that is known without the database. From any thread.
  virtual bool surely_none_over() const = 0;
  // The jobs whose leases are over, and maybe some that have no lease. With `lock`, nobody else changes them until the
  // transaction has ended, and those that another transaction changes are left out.
  virtual Result<std::vector<std::string>> over(Database& db, bool lock) = 0;
  virtual Result<std::vector<Current>> current(Database& db) = 0;
  // The clock of rests.
  virtual Result<Millis> now(Database& db) = 0;
};

}  // namespace vacuform
