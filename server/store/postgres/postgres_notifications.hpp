// Changes of jobs among several servers on one database. Each server tells the others which jobs have changed, after the
// commit: a NOTIFY within a transaction makes all commits wait for one another. A notification may be lost, so that
// waiters also look for themselves (News).
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "api/base/file.hpp"
#include "server/store/notifications.hpp"
#include "server/store/postgres/postgres.hpp"

namespace vacuform {

// Two threads: one sends, one listens on a connection of its own and opens it again when it is lost.
class PostgresNotifications {
 public:
  PostgresNotifications(PostgresPool& pool, Notifications& news);
  PostgresNotifications(const PostgresNotifications&) = delete;
  ~PostgresNotifications();

  // Tells the other servers soon: several changes within 20 ms go in one statement. From any thread.
  void send(const std::vector<std::string>& jobs);
  // Whether a notification that this server sent to itself has arrived. Behind some poolers none ever does.
  bool hears() const { return hears_; }

 private:
  void send_all();
  void listen();
  Result<void> listen_once();
  bool stopping() const { return stop_; }

  PostgresPool& pool_;
  Notifications& notifications_;
  const std::string test_;  // payload of the notification to itself
  File wake_;               // becomes readable when the threads are to end
  std::atomic<bool> stop_{false}, hears_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> unsent_;
  std::thread sender_, listener_;
};

}  // namespace vacuform
