#include "server/store/sqlite/group_commit.hpp"

namespace vacuform {

Result<void> GroupCommit::run(const std::function<bool()>& change) {
  Waiting self{change};
  std::unique_lock queue(queue_mutex_);
  queue_.push_back(&self);
  self.wake.wait(queue, [&] { return self.done || (!leading_ && queue_.front() == &self); });
  if (self.done) return self.result;

  std::vector<Waiting*> batch;
  batch.swap(queue_);
  leading_ = true;
  queue.unlock();
  run_together(batch);
  queue.lock();
  leading_ = false;
  for (Waiting* waiting : batch) {
    waiting->done = true;
    waiting->wake.notify_one();
  }
  if (!queue_.empty()) queue_.front()->wake.notify_one();
  return self.result;
}

Result<void> GroupCommit::transaction(const std::vector<Waiting*>& batch) {
  const auto run = [&](const char* sql) { return Query(db_, sql).run(); };
  const auto all = [&]() -> Result<void> {
    VACUFORM_CHECK(run("BEGIN IMMEDIATE"));
    for (const Waiting* waiting : batch) {
      VACUFORM_CHECK(run("SAVEPOINT change"));
      if (!waiting->change()) VACUFORM_CHECK(run("ROLLBACK TO change"));
      VACUFORM_CHECK(run("RELEASE change"));
    }
    return run("COMMIT");
  };
  auto result = all();
  // SQLite may have rolled back already; then this is refused and changes nothing.
  if (!result) (void)db_.execute("ROLLBACK");
  return result;
}

void GroupCommit::run_together(const std::vector<Waiting*>& batch) {
  const std::lock_guard hold(database_mutex_);
  auto result = transaction(batch);
  if (db_.take_perhaps_full()) {
    make_room_();
    if (!result) {
      ended_transaction_(false);
      result = transaction(batch);
    }
    (void)db_.take_perhaps_full();
  }
  if (!result)
    for (Waiting* waiting : batch) waiting->result = result;
  ended_transaction_(result.has_value());
}

}  // namespace vacuform
