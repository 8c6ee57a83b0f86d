// Estimates for people who wait for a job, each from a bounded number of rows.
#include <algorithm>
#include <map>

#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

constexpr std::int64_t most_ended = 200;   // newest jobs that succeeded, of which those of the kind count
constexpr std::size_t most_compared = 20;  // jobs behind a median
constexpr double similar = 4;              // ratio of the sizes of two scans

double median(std::vector<Millis> times) {
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  if (times.size() % 2 == 1) return static_cast<double>(*middle);
  return static_cast<double>(*middle + *std::max_element(times.begin(), middle)) / 2;
}

}  // namespace

Result<Estimate> SqlStore::estimate(const Job& job) {
  return read([&](Database& db) -> Result<Estimate> {
    Estimate estimate;
    if (ended(job.state)) return estimate;
    if (job.state == JobState::queued) {
      VACUFORM_TRY(position, queue_position(db, job));
      estimate.queue_position = position;
    }
    VACUFORM_TRY(seconds, seconds_expected(db, job));
    estimate.seconds_expected = seconds;
    return estimate;
  });
}

// As next_queued() goes: first the raised jobs, then the owners in turn.
Result<std::int64_t> SqlStore::queue_position(Database& db, const Job& job) {
  std::int64_t raised_before = 0;
  std::map<std::string, std::int64_t> raised;  // by owner
  Query all_raised(db,
                   "SELECT owner, count(*), count(*) FILTER (WHERE priority>?1 OR (priority=?1 AND id<=?2))"
                   " FROM job INDEXED BY job_raised WHERE state='queued' AND priority>0 GROUP BY owner",
                   job.priority, job.id);
  for (;;) {
    VACUFORM_TRY(more, all_raised.row());
    if (!more) break;
    raised[all_raised.text(0)] = all_raised.integer(1);
    raised_before += job.priority > 0 ? all_raised.integer(2) : all_raised.integer(1);
  }
  if (job.priority > 0) return raised_before;
  Query own(db,
            "SELECT count(*) FROM job INDEXED BY job_queue WHERE state='queued' AND owner=?1 AND priority<=0"
            " AND priority>=?2 AND (priority>?2 OR id<=?3)",
            job.owner, job.priority, job.id);
  VACUFORM_CHECK(own.row());
  const std::int64_t turn = own.integer(0);  // of its owner, from 1
  std::int64_t position = raised_before;
  bool before = true;  // of the owners that have their turns before this one's
  Query turns(db, "SELECT owner, queued FROM submitter WHERE queued>0 ORDER BY running, served, owner");
  for (;;) {
    VACUFORM_TRY(more, turns.row());
    if (!more) return std::max<std::int64_t>(position, 1);
    const std::string owner = turns.text(0);
    const std::int64_t waiting = turns.integer(1) - (raised.contains(owner) ? raised[owner] : 0);
    if (owner == job.owner) before = false;
    position += owner == job.owner ? turn : std::min(waiting, before ? turn : turn - 1);
  }
}

// The median of the last jobs of this kind whose scan is of a similar size; without such jobs, of all of this kind.
Result<std::optional<double>> SqlStore::seconds_expected(Database& db, const Job& job) {
  const Input* const scan = job.input("scan");
  const double bytes = scan ? static_cast<double>(scan->blob.bytes) : 0;
  std::vector<Millis> like_it, of_kind;
  Query ended(
      db,
      "SELECT job.ended-job.started, input.bytes FROM"
      " (SELECT id, kind FROM job INDEXED BY job_by_state WHERE state='succeeded' ORDER BY id DESC LIMIT ?)"
      " AS newest JOIN job ON job.id=newest.id JOIN input ON input.job=job.id AND input.name='scan'"
      " WHERE newest.kind=? AND job.ended>=job.started ORDER BY newest.id DESC",
      most_ended, name(job.kind));
  while (like_it.size() < most_compared) {
    VACUFORM_TRY(more, ended.row());
    if (!more) break;
    const auto other = static_cast<double>(ended.integer(1));
    if (of_kind.size() < most_compared) of_kind.push_back(ended.integer(0));
    if (other <= bytes * similar && bytes <= other * similar) like_it.push_back(ended.integer(0));
  }
  const std::vector<Millis>& times = like_it.empty() ? of_kind : like_it;
  if (times.empty()) return std::optional<double>();
  return std::optional(median(times) / 1000);
}

}  // namespace vacuform
