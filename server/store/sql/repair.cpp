#include "server/store/sql/repair.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "api/base/file.hpp"
#include "api/base/secrets.hpp"
#include "server/store/blobs/files/file_blobs.hpp"
#include "server/store/folder_mark.hpp"
#include "server/store/postgres/postgres_schema.hpp"
#include "server/store/sql/backup.hpp"
#include "server/store/sql/sql_store.hpp"
#include "server/store/sqlite/rows_file.hpp"
#include "server/store/sqlite/sqlite_schema.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr const char* database_files[] = {"jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm", "database-id"};

// A new folder in the quarantine, named by the time.
Result<fs::path> new_quarantine(const fs::path& data, const std::string& what) {
  const fs::path folder =
      data / "quarantine" / (what + "-" + std::to_string(wall_clock()) + "-" + random_hex(2));
  VACUFORM_CHECK(make_directory(folder));
  return folder;
}

Result<void> move_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error || error == std::errc::no_such_file_or_directory) return {};
  return fail(Code::unavailable, "a file cannot be moved: " + error.message(), from.string(),
              "check that this user may write to the data folder");
}

Result<void> move_database(const fs::path& data, const fs::path& to) {
  for (const char* name : database_files) VACUFORM_CHECK(move_file(data / name, to / name));
  return {};
}

Result<void> copy_flushed(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (error)
    return fail(error == std::errc::no_space_on_device ? Code::disk_full : Code::unavailable,
                "a file cannot be copied: " + error.message(), from.string(), "check the disk");
  VACUFORM_TRY(file, File::open(to));
  return file.sync();
}

// The tables with rows of a job. Statements live as long as the program, as Database::prepared() wants it.
struct JobRows {
  const char* table;
  std::string columns, select;
};

const std::vector<JobRows>& rows_of_a_job() {
  static const std::vector<JobRows> all = [] {
    std::vector<JobRows> tables;
    for (const CopiedTable& table : copied_tables()) {
      const std::string_view name = table.name;
      if (name != "job" && name != "input" && name != "artifact" && name != "job_log") continue;
      tables.push_back({table.name, table.columns,
                        std::string("SELECT ") + table.columns + " FROM " + table.name + " WHERE " +
                            (name == "job" ? "id" : "job") + "=?"});
    }
    return tables;
  }();
  return all;
}

// As far as they can be read.
nlohmann::ordered_json rows_of(Database& db, const std::string& id) {
  nlohmann::ordered_json all;
  for (const JobRows& table : rows_of_a_job()) {
    nlohmann::ordered_json& rows =
        all[table.table] = {{"columns", table.columns}, {"rows", nlohmann::ordered_json::array()}};
    Query query(db, table.select.c_str(), id);
    const auto count = 1 + std::ranges::count(table.columns, ',');
    while (query.row().value_or(false)) {
      nlohmann::ordered_json row;
      for (int i = 0; i < count; ++i) row.push_back(query.text(i));
      rows["rows"].push_back(std::move(row));
    }
  }
  return all;
}

}  // namespace

Result<bool> repair_pages(const fs::path& data) {
  VACUFORM_TRY(lock, lock_data_folder(data));
  VACUFORM_CHECK(make_directory(data / "incoming"));
  std::string fault;
  const fs::path fresh = data / "incoming" / ("jobs-" + random_hex(8));
  {
    SqliteDatabase db;
    VACUFORM_CHECK(db.open((data / "jobs.sqlite").string()));
    VACUFORM_TRY(found, page_fault(db, PageCheck::full));
    if (found.empty()) return false;
    fault = found;
    (void)db.execute("PRAGMA wal_checkpoint(TRUNCATE)");
  }
  VACUFORM_CHECK(copy_flushed(data / "jobs.sqlite", fresh));
  {
    SqliteDatabase db;
    VACUFORM_CHECK(db.open(fresh.string()));
    if (!db.execute("REINDEX; VACUUM"))
      return fail(Code::corrupt_file,
                  "the job store is damaged, and not all of its rows can be read: " + fault, "jobs.sqlite",
                  "restore a backup with vacuform-server restore");
    VACUFORM_TRY(found, page_fault(db, PageCheck::full));
    if (!found.empty())
      return fail(Code::corrupt_file, "the job store cannot be rewritten: " + found, "jobs.sqlite",
                  "restore a backup with vacuform-server restore");
  }
  VACUFORM_TRY(mark, read_folder_mark(data));
  VACUFORM_TRY(aside, new_quarantine(data, "database"));
  VACUFORM_CHECK(move_database(data, aside));
  if (!mark.database.empty()) VACUFORM_CHECK(write_folder_mark(data, mark));
  VACUFORM_CHECK(move_file(fresh, data / "jobs.sqlite"));
  VACUFORM_CHECK(sync_directory(data));
  return true;
}

Result<void> SqlStore::set_job_in_quarantine(const std::string& id, const fs::path& folder) {
  nlohmann::ordered_json rows;
  const auto done = read_rows([&](Database& db) -> Result<void> {
    rows = rows_of(db, id);
    return {};
  });
  VACUFORM_CHECK(done);
  VACUFORM_CHECK(
      write_text_file(folder / ("job-" + std::to_string(wall_clock()) + "-" + random_hex(4) + ".json"),
                      rows.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"));
  return write(
      [&](Transaction& tx) -> Result<void> { return Query(tx.db, "DELETE FROM job WHERE id=?", id).run(); });
}

Result<void> set_damage_in_quarantine(const fs::path& data, Store& store, const StoreCheck& found) {
  auto& rows = dynamic_cast<SqlStore&>(store);
  if (found.damaged_jobs.empty() && found.damaged_files.empty() && found.unnamed.empty()) return {};
  VACUFORM_CHECK(make_directory(data / "quarantine"));
  for (const std::string& id : found.damaged_jobs)
    VACUFORM_CHECK(rows.set_job_in_quarantine(id, data / "quarantine"));
  for (const std::string& sha256 : found.damaged_files)
    VACUFORM_CHECK(rows.blobs().set_in_quarantine(sha256));
  for (const std::string& sha256 : found.unnamed) VACUFORM_CHECK(rows.blobs().set_in_quarantine(sha256));
  return {};
}

Result<RestoreReport> restore_backup(const fs::path& backup, const fs::path& data) {
  std::error_code error;
  if (!fs::exists(backup / "jobs.sqlite", error))
    return fail(Code::bad_usage, "there is no backup in this folder", backup.string(),
                "give a folder that vacuform-server backup has written");
  if (fs::equivalent(backup, data, error))
    return fail(Code::bad_usage, "the backup is the data folder itself", backup.string(),
                "give the folder of the backup with --from");
  VACUFORM_TRY(lock, lock_data_folder(data));
  for (const char* folder : {"incoming", "blobs"}) VACUFORM_CHECK(make_directory(data / folder));
  RowsFile copy(data / "incoming" / ("jobs-" + random_hex(8)));
  VACUFORM_CHECK(copy_flushed(backup / "jobs.sqlite", copy.path()));
  VACUFORM_CHECK(copy.open());
  VACUFORM_TRY(fault, page_fault(copy.db(), PageCheck::full));
  if (!fault.empty())
    return fail(Code::corrupt_file, "the database of the backup is damaged: " + fault, backup.string(),
                "take another backup");
  VACUFORM_CHECK(bring_up_to_date(copy.db()));
  VACUFORM_TRY(number, number_rows(copy.db()));
  VACUFORM_TRY(hashes, named_hashes(copy.db()));
  const auto of_backup = FileBlobs::existing(backup), of_data = FileBlobs::existing(data);
  RestoreReport report;
  for (const std::string& sha256 : hashes) {
    const auto there = of_data->check(sha256, true, [](std::uint64_t) { return true; });
    if (!there && there.error().code == Code::gone) VACUFORM_CHECK(of_data->set_in_quarantine(sha256));
    const auto copied = there ? there : of_backup->copy(sha256, data / "blobs");
    if (!copied && copied.error().code == Code::unavailable) return tl::make_unexpected(copied.error());
    if (copied)
      ++report.files;
    else
      report.damaged.push_back(sha256);
  }
  {
    Query count(copy.db(), "SELECT count(*) FROM job");
    VACUFORM_CHECK(count.row());
    report.jobs = count.integer(0);
  }
  VACUFORM_TRY(aside, new_quarantine(data, "database"));
  VACUFORM_CHECK(move_database(data, aside));
  copy.close();
  VACUFORM_CHECK(move_file(copy.path(), data / "jobs.sqlite"));
  VACUFORM_CHECK(write_folder_mark(data, {sqlite_name, number}));
  return report;
}

}  // namespace vacuform
