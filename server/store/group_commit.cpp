#include "server/store/group_commit.hpp"

namespace vacuform {

Result<void> GroupCommit::run(const std::function<bool()>& change) {
  Waiting self{change};
  std::unique_lock queue(queue_mutex_);
  queue_.push_back(&self);
  ended_.wait(queue, [&] { return self.done || !leading_; });
  if (self.done) return self.result;

  std::vector<Waiting*> batch;
  batch.swap(queue_);
  leading_ = true;
  queue.unlock();
  run_together(batch);
  queue.lock();
  leading_ = false;
  for (Waiting* waiting : batch) waiting->done = true;
  ended_.notify_all();
  return self.result;
}

Result<void> GroupCommit::transaction(const std::vector<Waiting*>& batch) {
  const auto all = [&]() -> Result<void> {
    VACUFORM_CHECK(db_.execute("BEGIN IMMEDIATE"));
    for (const Waiting* waiting : batch) {
      VACUFORM_CHECK(db_.execute("SAVEPOINT change"));
      if (!waiting->change()) VACUFORM_CHECK(db_.execute("ROLLBACK TO change"));
      VACUFORM_CHECK(db_.execute("RELEASE change"));
    }
    return db_.execute("COMMIT");
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
