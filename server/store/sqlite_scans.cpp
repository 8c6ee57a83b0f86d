#include <algorithm>

#include "server/store/job_id.hpp"
#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

StoredScan scan_of(const Query& row) {
  return {row.text(0),
          row.text(1),
          row.integer(2),
          {row.text(3), static_cast<std::uint64_t>(row.integer(4))},
          row.text(5)};
}

}  // namespace

Result<StoredScan> SqliteStore::add_scan(const std::string& owner, std::variant<Upload, Blob> file,
                                         const std::string& extension) {
  const Deletion deletion(*this);
  Stored stored(*this);
  NewInput input{"scan", std::move(file), extension};
  VACUFORM_TRY(blob, stored.add(input.file));
  auto added = write([&]() -> Result<StoredScan> {
    {
      Query same(db_,
                 "SELECT id, owner, created, blob, bytes, extension FROM scan"
                 " WHERE owner=? AND blob=? AND extension=?",
                 owner, blob.sha256, extension);
      VACUFORM_TRY(found, same.row());
      if (found) return scan_of(same);
    }
    VACUFORM_CHECK(room_for(0));
    VACUFORM_CHECK(check_shared(input));
    last_id_time_ = std::max(options_.clock(), last_id_time_ + 1);
    const StoredScan scan{make_job_id(last_id_time_), owner, options_.clock(), blob, extension};
    VACUFORM_CHECK(Query(db_,
                         "INSERT INTO scan(id, owner, created, blob, bytes, extension) VALUES(?,?,?,?,?,?)",
                         scan.id, scan.owner, scan.created, blob.sha256, blob.bytes, extension)
                       .run());
    return scan;
  });
  stored.named = added.has_value();
  return added;
}

Result<StoredScan> SqliteStore::scan_row(const std::string& id) {
  Query query(db_, "SELECT id, owner, created, blob, bytes, extension FROM scan WHERE id=?", id);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such scan", id, "see the list of scans");
  return scan_of(query);
}

Result<StoredScan> SqliteStore::find_scan(const std::string& id) {
  const std::lock_guard hold(commits_.lock());
  return scan_row(id);
}

Result<ScanPage> SqliteStore::list_scans(int limit, const std::string& cursor,
                                         const std::optional<std::string>& owner) {
  const std::lock_guard hold(commits_.lock());
  limit = std::clamp(limit, 1, 100);
  ScanPage page;
  const std::string before = cursor.empty() ? "~" : cursor;
  const auto collect = [&](Query query) -> Result<void> {
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return {};
      page.scans.push_back(scan_of(query));
    }
  };
  VACUFORM_CHECK(owner ? collect({db_,
                                  "SELECT id, owner, created, blob, bytes, extension FROM scan"
                                  " WHERE owner=? AND id<? ORDER BY id DESC LIMIT ?",
                                  *owner, before, limit + 1})
                       : collect({db_,
                                  "SELECT id, owner, created, blob, bytes, extension FROM scan"
                                  " WHERE id<? ORDER BY id DESC LIMIT ?",
                                  before, limit + 1}));
  if (page.scans.size() > static_cast<std::size_t>(limit)) {
    page.scans.pop_back();
    page.next = page.scans.back().id;
  }
  return page;
}

Result<void> SqliteStore::remove_scan(const std::string& id) {
  const Deletion deletion(*this);
  return write([&]() -> Result<void> {
    VACUFORM_TRY(scan, scan_row(id));
    maybe_garbage(scan.blob.sha256);
    return Query(db_, "DELETE FROM scan WHERE id=?", id).run();
  });
}

Result<bool> SqliteStore::names_scan(const std::string& owner, const std::string& sha256) {
  const std::lock_guard hold(commits_.lock());
  Query query(db_, "SELECT 1 FROM input JOIN job ON job.id=input.job WHERE blob=? AND owner=? LIMIT 1",
              sha256, owner);
  return query.row();
}

Result<std::vector<std::pair<std::string, std::string>>> SqliteStore::scans_of_jobs() {
  const std::lock_guard hold(commits_.lock());
  std::vector<std::pair<std::string, std::string>> scans;
  Query query(db_, "SELECT DISTINCT owner, blob FROM input JOIN job ON job.id=input.job WHERE name='scan'");
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return scans;
    scans.emplace_back(query.text(0), query.text(1));
  }
}

}  // namespace vacuform
