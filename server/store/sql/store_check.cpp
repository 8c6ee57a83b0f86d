// A look at all that the store keeps.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

constexpr int at_once = 200;

tl::unexpected<Error> check_cancelled() { return fail(Code::cancelled, "the check was cancelled"); }

Result<std::vector<std::string>> texts_of(Query& query) {
  std::vector<std::string> texts;
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return texts;
    texts.push_back(query.text(0));
  }
}

Result<std::vector<std::string>> jobs_after(Database& db, const std::string& id) {
  Query query(db, "SELECT id FROM job WHERE id>? ORDER BY id LIMIT ?", id, at_once);
  return texts_of(query);
}

#define VACUFORM_BLOBS(table) \
  "SELECT blob FROM (SELECT blob FROM " table " WHERE blob>?1 ORDER BY blob LIMIT ?2) AS " table "_blobs"

Result<std::vector<std::string>> blobs_after(Database& db, const std::string& sha256) {
  Query query(db,
              VACUFORM_BLOBS("input") " UNION " VACUFORM_BLOBS("artifact") " UNION " VACUFORM_BLOBS(
                  "scan") " UNION " VACUFORM_BLOBS("upload") " UNION " VACUFORM_BLOBS("upload_piece")
              " ORDER BY blob LIMIT ?2",
              sha256, at_once);
  return texts_of(query);
}

#undef VACUFORM_BLOBS

}  // namespace

Result<StoreCheck> SqlStore::check(bool read_bytes, const CheckGoing& going) {
  StoreCheck found;
  const auto go_on = [&] { return going(0); };
  VACUFORM_TRY(fault, page_fault(go_on));
  found.pages = fault;
  if (!fault.empty()) log_event("store-damaged", {{"problem", fault}});
  for (std::string last;;) {
    if (!go_on()) return check_cancelled();
    auto ids = read([&](Database& db) -> Result<std::vector<std::string>> {
      VACUFORM_TRY(some, jobs_after(db, last));
      for (const std::string& id : some) {
        const auto row = find_row(db, id, Lock::no, Detail::full);
        if (row || row.error().code == Code::not_found) continue;
        if (!is_damage(row.error(), id)) return tl::make_unexpected(row.error());
        found.damaged_jobs.push_back(id);
      }
      return some;
    });
    if (!ids) return tl::make_unexpected(ids.error());
    if (ids->empty()) break;
    found.jobs += static_cast<std::int64_t>(ids->size());
    last = ids->back();
  }
  std::set<std::string> damaged;
  for (std::string last;;) {
    auto hashes = read([&](Database& db) { return blobs_after(db, last); });
    if (!hashes) return tl::make_unexpected(hashes.error());
    if (hashes->empty()) break;
    last = hashes->back();
    for (const std::string& sha256 : *hashes) {
      if (!go_on()) return check_cancelled();
      const auto checked = blobs_->check(sha256, read_bytes, [&](std::uint64_t bytes) {
        found.bytes += static_cast<std::int64_t>(bytes);
        return going(bytes);
      });
      ++found.files;
      if (checked) continue;
      const Code code = checked.error().code;
      if (code == Code::cancelled || code == Code::unavailable) return tl::make_unexpected(checked.error());
      // It may have been deleted in the meantime.
      const auto wanted = read([&](Database& db) { return named(db, sha256); });
      if (!wanted) return tl::make_unexpected(wanted.error());
      if (!*wanted) continue;
      damaged.insert(sha256);
      (code == Code::gone ? found.damaged_files : found.missing_files).push_back(sha256);
      if (code != Code::gone) log_event("blob-missing", {{"blob", sha256}});
    }
  }
  const auto unnamed = blobs_->unnamed(
      [this](const std::string& sha256) { return read([&](Database& db) { return named(db, sha256); }); });
  if (!unnamed) return tl::make_unexpected(unnamed.error());
  found.unnamed = unnamed->hashes, found.unnamed_bytes = unnamed->bytes;
  {
    const std::lock_guard hold(damage_mutex_);
    if (read_bytes)
      damaged_files_ = std::move(damaged);
    else
      damaged_files_.merge(damaged);
    unnamed_files_ = unnamed->files, unnamed_bytes_ = unnamed->bytes;
  }
  if (const auto noted = remember(read_bytes ? "last_check" : "last_look"); !noted)
    log_event("store-failed", {{"problem", noted.error().text()}});
  return found;
}

}  // namespace vacuform
