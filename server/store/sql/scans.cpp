#include <algorithm>

#include "server/store/sql/sql_store.hpp"

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

Result<StoredScan> SqlStore::add_scan(const std::string& owner, std::variant<Upload, Blob> file,
                                      const std::string& extension) {
  const Deletion deletion(*this);
  Stored stored(*this);
  NewInput input{"scan", std::move(file), extension};
  VACUFORM_TRY(blob, stored.add(input.file));
  auto added = write([&](Transaction& tx) -> Result<StoredScan> {
    {
      Query same(tx.db,
                 "SELECT id, owner, created, blob, bytes, extension FROM scan"
                 " WHERE owner=? AND blob=? AND extension=?",
                 owner, blob.sha256, extension);
      VACUFORM_TRY(found, same.row());
      if (found) return scan_of(same);
    }
    VACUFORM_CHECK(room_for(0));
    VACUFORM_CHECK(SharedBlobs(tx.db, {&input, 1}).check());
    VACUFORM_CHECK(hold_objects(tx.db, {blob.sha256}));
    const StoredScan scan{next_id(), owner, options_.clock(), blob, extension};
    VACUFORM_CHECK(Query(tx.db,
                         "INSERT INTO scan(id, owner, created, blob, bytes, extension) VALUES(?,?,?,?,?,?)",
                         scan.id, scan.owner, scan.created, blob.sha256, blob.bytes, extension)
                       .run());
    return scan;
  });
  stored.written(added);
  return added;
}

Result<StoredScan> SqlStore::scan_row(Database& db, const std::string& id) {
  Query query(db, "SELECT id, owner, created, blob, bytes, extension FROM scan WHERE id=?", id);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such scan", id, "see the list of scans");
  return scan_of(query);
}

Result<StoredScan> SqlStore::find_scan(const std::string& id) {
  return read([&](Database& db) -> Result<StoredScan> { return scan_row(db, id); });
}

Result<ScanPage> SqlStore::list_scans(int limit, const std::string& cursor,
                                      const std::optional<std::string>& owner) {
  return read([&](Database& db) -> Result<ScanPage> {
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
    VACUFORM_CHECK(owner ? collect({db,
                                    "SELECT id, owner, created, blob, bytes, extension FROM scan"
                                    " WHERE owner=? AND id<? ORDER BY id DESC LIMIT ?",
                                    *owner, before, limit + 1})
                         : collect({db,
                                    "SELECT id, owner, created, blob, bytes, extension FROM scan"
                                    " WHERE id<? ORDER BY id DESC LIMIT ?",
                                    before, limit + 1}));
    if (page.scans.size() > static_cast<std::size_t>(limit)) {
      page.scans.pop_back();
      page.next = page.scans.back().id;
    }
    return page;
  });
}

Result<void> SqlStore::remove_scan(const std::string& id) {
  const Deletion deletion(*this);
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_TRY(scan, scan_row(tx.db, id));
    tx.garbage.push_back(scan.blob.sha256);
    return Query(tx.db, "DELETE FROM scan WHERE id=?", id).run();
  });
}

Result<bool> SqlStore::names_scan(const std::string& owner, const std::string& sha256) {
  return read([&](Database& db) -> Result<bool> {
    Query query(db, "SELECT 1 FROM input JOIN job ON job.id=input.job WHERE blob=? AND owner=? LIMIT 1",
                sha256, owner);
    return query.row();
  });
}

Result<std::vector<std::pair<std::string, std::string>>> SqlStore::scans_of_jobs() {
  return read([&](Database& db) -> Result<std::vector<std::pair<std::string, std::string>>> {
    std::vector<std::pair<std::string, std::string>> scans;
    Query query(db, "SELECT DISTINCT owner, blob FROM input JOIN job ON job.id=input.job WHERE name='scan'");
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return scans;
      scans.emplace_back(query.text(0), query.text(1));
    }
  });
}

}  // namespace vacuform
