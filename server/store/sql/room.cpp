#include <algorithm>

#include "server/store/sql/sql_store.hpp"

namespace vacuform {

Result<std::int64_t> SqlStore::seconds_until_room(const std::string& owner) {
  return read([&](Database& db) -> Result<std::int64_t> {
    constexpr std::int64_t unknown = 60, longest = 600, looked_at = 16;
    constexpr Millis lately = 15 * 60 * 1000;
    // Later jobs have greater ids, and end later but for a few: each half needs a few rows of one index.
    Query ended(
        db,
        "SELECT count(*), min(ended), max(ended) FROM ("
        " SELECT ended FROM (SELECT ended FROM job WHERE state='succeeded' ORDER BY id DESC LIMIT ?1) AS good"
        " UNION ALL SELECT ended FROM (SELECT ended FROM job WHERE state='failed' ORDER BY id DESC LIMIT ?1) "
        "AS bad"
        " ORDER BY ended DESC LIMIT ?1) AS newest WHERE ended>?2",
        looked_at, options_.clock() - lately);
    VACUFORM_CHECK(ended.row());
    if (ended.integer(0) < 2) return unknown;
    Query queue(db,
                "SELECT coalesce(sum(queued), 0), count(*) FILTER (WHERE queued>0),"
                " coalesce(sum(queued) FILTER (WHERE owner=?), 0) FROM submitter",
                owner);
    VACUFORM_CHECK(queue.row());
    // A place is free for everybody with each job, and for one owner with each of his.
    const std::int64_t turns =
        queue.integer(2) >= options_.most_queued_by_owner ? std::max<std::int64_t>(1, queue.integer(1)) : 1;
    const Millis one = (ended.integer(2) - ended.integer(1)) / (ended.integer(0) - 1);
    return std::clamp<std::int64_t>((turns * one + 999) / 1000, 1, longest);
  });
}

}  // namespace vacuform
