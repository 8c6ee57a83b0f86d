#include "server/store/postgres/postgres_notifications.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/secrets.hpp"

namespace vacuform {

namespace {

constexpr std::chrono::milliseconds pause_between_sends(20);
constexpr std::chrono::seconds pause_after_loss(1), time_for_test(5);
constexpr const char* listen_to_jobs = "LISTEN vacuform_job";
constexpr const char* notify_of_jobs =
    "SELECT pg_notify('vacuform_job', id) FROM unnest(string_to_array(?, ',')) AS id";

}  // namespace

PostgresNotifications::PostgresNotifications(PostgresPool& pool, Notifications& news)
    : pool_(pool), notifications_(news), test_("test-" + random_hex(8)), wake_(::eventfd(0, EFD_CLOEXEC)) {
  sender_ = std::thread([this] { send_all(); });
  listener_ = std::thread([this] { listen(); });
}

PostgresNotifications::~PostgresNotifications() {
  {
    const std::lock_guard hold(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  ::eventfd_write(wake_.descriptor(), 1);
  sender_.join();
  listener_.join();
}

void PostgresNotifications::send(const std::vector<std::string>& jobs) {
  const std::lock_guard hold(mutex_);
  unsent_.insert(jobs.begin(), jobs.end());
  changed_.notify_all();
}

void PostgresNotifications::send_all() {
  std::unique_lock hold(mutex_);
  for (;;) {
    changed_.wait(hold, [&] { return stop_ || !unsent_.empty(); });
    if (stop_) return;
    std::string jobs;
    for (const std::string& job : unsent_) jobs.append(jobs.empty() ? "" : ",").append(job);
    unsent_.clear();
    hold.unlock();
    // One that is not sent is found by the other servers' own looks.
    (void)pool_.with(
        [&](PostgresConnection& connection) { return Query(connection, notify_of_jobs, jobs).run(); });
    hold.lock();
    changed_.wait_for(hold, pause_between_sends, [&] { return stop_.load(); });
  }
}

void PostgresNotifications::listen() {
  for (bool first = true; !stop_; first = false) {
    const auto listened = listen_once();
    const bool heard = hears_.exchange(false);
    if (stop_) return;
    if (!listened && (first || heard))
      log_event("notifications-lost", {{"problem", listened.error().text()}});
    std::unique_lock hold(mutex_);
    changed_.wait_for(hold, pause_after_loss, [&] { return stop_.load(); });
  }
}

Result<void> PostgresNotifications::listen_once() {
  VACUFORM_TRY(connection, PostgresConnection::open(pool_.url()));
  VACUFORM_CHECK(connection->execute(listen_to_jobs));
  send({test_});
  const auto until = std::chrono::steady_clock::now() + time_for_test;
  bool told = false;
  notifications_.tell_all();  // what changed before is not notified any more
  while (!stop_) {
    VACUFORM_TRY(job, connection->notification(std::chrono::seconds(1), wake_.descriptor()));
    if (job && *job == test_) {
      hears_ = true;
      if (told) log_event("notifications-back", nlohmann::ordered_json::object());
    } else if (job) {
      notifications_.tell({*job});
    } else if (!hears_ && !told && std::chrono::steady_clock::now() > until) {
      log_event(
          "notifications-missing",
          {{"fix", "connect to PostgreSQL directly; until then, changes are noticed every two seconds"}});
      told = true;
    }
  }
  return {};
}

}  // namespace vacuform
