#include "server/store/sqlite/sqlite_schema.hpp"

#include <array>

#include "server/store/schemas.hpp"

namespace vacuform {

namespace {

constexpr int application = 0x56666d31;  // "Vfm1": the file is ours

// What takes a database from version i to i + 1; a new one goes through all of them. A change is never edited once it was
// released. A submitter's row follows from those of its jobs.
constexpr std::array changes{sqlite_schema_1};

}  // namespace

const std::int64_t newest_schema = changes.size();

Result<void> bring_up_to_date(Database& db, std::int64_t wanted) {
  std::int64_t app = 0, version = 0, tables = 0;
  {
    Query query(db,
                "SELECT application_id, user_version, (SELECT count(*) FROM sqlite_schema)"
                " FROM pragma_application_id, pragma_user_version");
    VACUFORM_TRY(found, query.row());
    if (found) app = query.integer(0), version = query.integer(1), tables = query.integer(2);
  }
  const bool empty = app == 0 && version == 0 && tables == 0;
  if (!empty && (app != application || version < 1))
    return fail(Code::corrupt_file, "the file is not a job store of Vacuform", "jobs.sqlite",
                "give another folder with --data");
  if (version > newest_schema)
    return fail(Code::corrupt_file,
                "the job store has version " + std::to_string(version) + ", this server knows " +
                    std::to_string(newest_schema),
                "jobs.sqlite", "start the server that wrote it, or give another folder with --data");
  if (version >= wanted) return {};
  std::string all = "BEGIN IMMEDIATE;";
  for (std::int64_t i = version; i < wanted; ++i) all += changes[i];
  return db.execute(all + "PRAGMA application_id=" + std::to_string(application) +
                    ";PRAGMA user_version=" + std::to_string(wanted) + ";COMMIT");
}

}  // namespace vacuform
