#include "server/store/sql/backup.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "server/store/folder_mark.hpp"
#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

namespace {

namespace fs = std::filesystem;

// The caller must have made the folder as the user of the server, so that files of other users are not accessible.
Result<void> check_target(const fs::path& to) {
  struct stat status {};
  std::error_code error;
  if (to.is_absolute() && ::lstat(to.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
      status.st_uid == ::geteuid() && (status.st_mode & 077) == 0 && fs::is_empty(to, error) && !error)
    return {};
  return fail(Code::bad_usage, "not an empty private folder of the server's user", to.string(),
              "give the absolute path of a folder that is empty, with mode 0700");
}

Result<std::int64_t> jobs_in(Database& db) {
  VACUFORM_TRY(fault, page_fault(db, PageCheck::full));
  if (!fault.empty())
    return fail(Code::internal, "the copy of the job store is damaged: " + fault, "jobs.sqlite",
                "the store itself may be: restore it from an older backup");
  Query count(db, "SELECT count(*) FROM job");
  VACUFORM_CHECK(count.row());
  return count.integer(0);
}

// The blobs of the copy are files, wherever those of the store are.
Result<void> forget_bucket(Database& db) {
  return db.execute("BEGIN; DELETE FROM stored_object; DELETE FROM remembered WHERE name='bucket'; COMMIT");
}

// A restored backup would begin again what was signed out after it, and bring back links that were used.
Result<void> forget_sessions(Database& db) {
  return db.execute("BEGIN; DELETE FROM session; DELETE FROM sign_in_link; COMMIT");
}

}  // namespace

Result<std::vector<std::string>> named_hashes(Database& db) {
  std::vector<std::string> hashes;
  Query query(db,
              "SELECT blob FROM input UNION SELECT blob FROM artifact UNION SELECT blob FROM scan"
              " UNION SELECT blob FROM upload WHERE blob IS NOT NULL");
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) return hashes;
    hashes.push_back(query.text(0));
  }
}

Result<std::string> number_rows(Database& db) {
  const auto number = random_number() & 0x7fffffff;
  VACUFORM_CHECK(Query(db,
                       "INSERT INTO remembered(name, value) VALUES('database', ?) ON CONFLICT(name) DO UPDATE"
                       " SET value=excluded.value",
                       number)
                     .run());
  return std::to_string(number);
}

Result<BackupReport> make_backup(const fs::path& to, BlobStore& blobs,
                                 const std::function<Result<void>(const fs::path&)>& copy_rows,
                                 const std::function<bool()>& going,
                                 const std::function<Result<void>()>& done) {
  VACUFORM_CHECK(check_target(to));
  const fs::path file = to / "jobs.sqlite";
  VACUFORM_CHECK(copy_rows(file));
  BackupReport report;
  SqliteDatabase copy;
  VACUFORM_CHECK(copy.open(file.string()));
  VACUFORM_CHECK(forget_bucket(copy));
  VACUFORM_CHECK(forget_sessions(copy));
  VACUFORM_CHECK(copy.execute("DELETE FROM pending_deletion"));
  VACUFORM_TRY(number, number_rows(copy));
  VACUFORM_CHECK(write_folder_mark(to, {sqlite_name, number}));
  VACUFORM_TRY(jobs, jobs_in(copy));
  report.jobs = jobs;
  VACUFORM_TRY(hashes, named_hashes(copy));
  for (const std::string& sha256 : hashes) {
    if (!going()) return fail(Code::cancelled, "the backup was cancelled", to.string());
    const auto copied = blobs.copy(sha256, to / "blobs");
    if (!copied && copied.error().code == Code::unavailable) return tl::make_unexpected(copied.error());
    if (copied)
      ++report.blobs;
    else
      report.damaged.push_back(sha256);
  }
  VACUFORM_CHECK(sync_directory(to));
  if (const auto noted = done(); !noted)  // the copy is good all the same
    log_event("store-failed", {{"problem", noted.error().text()}});
  return report;
}

}  // namespace vacuform
