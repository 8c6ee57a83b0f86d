// One flush for many changes. A commit costs a flush of the disk; while one is under way the changes that
// arrive queue up, and the first of their threads then runs them all in one transaction. Nobody waits for a
// timer: alone, a change commits at once.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <vector>

#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

class GroupCommit {
 public:
  // `make_room` is called when a transaction may have found the disk full; then all of its changes are tried once more. `ended` is
  // called after each transaction with whether it was committed, still under the lock.
  GroupCommit(SqliteDatabase& db, std::function<void()> make_room, std::function<void(bool)> ended)
      : db_(db), make_room_(std::move(make_room)), ended_transaction_(std::move(ended)) {}

  // Runs `change` under the lock inside a savepoint, and returns when it is on the disk, or undone. It may run twice.
  // False from `change` undoes it alone and is no error. Errors: those of the transaction, which undid the change.
  Result<void> run(const std::function<bool()>& change);

  // Held while a transaction runs; hold it to read.
  std::mutex& lock() { return database_mutex_; }

 private:
  struct Waiting {
    const std::function<bool()>& change;
    Result<void> result = {};
    bool done = false;
    std::condition_variable wake = {};  // its thread: it is done, or the first in the queue
  };
  void run_together(const std::vector<Waiting*>& batch);
  Result<void> transaction(const std::vector<Waiting*>& batch);

  SqliteDatabase& db_;
  std::function<void()> make_room_;
  std::function<void(bool)> ended_transaction_;
  std::mutex database_mutex_;  // taken after the other, or alone
  std::mutex queue_mutex_;
  std::vector<Waiting*> queue_;
  bool leading_ = false;  // a thread runs a transaction
};

}  // namespace vacuform
