#include "server/store/postgres/postgres_schema.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "server/store/schemas.hpp"

namespace vacuform {

namespace {

// What takes a database from version i to i + 1. A server of the version before keeps working on it: a change adds, and
// what it makes superfluous goes with a later version.
constexpr std::array postgres_changes{postgres_schema_1};

constexpr std::array tables{
    CopiedTable{
        "job",
        "id, client_key, kind, state, stage, progress, attempt, losses, crashes, created, started, ended,"
        " worker, lease_hash, error_code, error_what, error_where, error_fix, error_proposals, settings, "
        "request, owner,"
        " priority, derived_from, not_before, version, log_lines, serious_warnings, reference, note,"
        " reference_changes",
        6},
    CopiedTable{"input", "job, name, blob, bytes, extension"},
    CopiedTable{"artifact", "job, name, blob, bytes"},
    CopiedTable{"job_log", "job, number, time, text"},
    CopiedTable{"token", "id, owner, scopes, hash, created, expires, revoked, file"},
    CopiedTable{"upload",
                "id, owner, input, extension, key, length, created, expires, collected, blob, bytes"},
    CopiedTable{"scan", "id, owner, created, blob, bytes, extension"},
    CopiedTable{"profile", "name, settings, changed, is_default"},
    CopiedTable{"remembered", "name, value", 0, "name NOT IN ('bucket', 'database')"},
};

Result<void> change_tables(Database& db, std::int64_t wanted) {
  VACUFORM_CHECK(db.take_turns("tables"));
  VACUFORM_CHECK(db.execute("CREATE TABLE IF NOT EXISTS vacuform_tables(version bigint NOT NULL)"));
  std::int64_t now = 0;
  {
    Query query(db, "SELECT coalesce(max(version), 0) FROM vacuform_tables");
    VACUFORM_CHECK(query.row());
    now = query.integer(0);
  }
  if (now > newest_postgres_schema)
    return fail(Code::corrupt_file,
                "the tables in the database have version " + std::to_string(now) + ", this server knows " +
                    std::to_string(newest_postgres_schema),
                {}, "start a server of the version that wrote them, or newer");
  if (now >= wanted) return {};
  for (std::int64_t i = now; i < wanted; ++i) VACUFORM_CHECK(db.execute(postgres_changes[i]));
  VACUFORM_CHECK(db.execute("DELETE FROM vacuform_tables"));
  return Query(db, "INSERT INTO vacuform_tables(version) VALUES(?)", wanted).run();
}

}  // namespace

const std::int64_t newest_postgres_schema = postgres_changes.size();

std::span<const CopiedTable> copied_tables() { return tables; }

std::string insertion(const CopiedTable& table) {
  const std::string columns = table.columns;
  std::string marks = "?";
  for (auto n = std::count(columns.begin(), columns.end(), ','); n > 0; --n) marks += ",?";
  return "INSERT INTO " + std::string(table.name) + "(" + columns + ") VALUES(" + marks + ")";
}

Result<void> bring_postgres_up_to_date(Database& db, std::int64_t version) {
  VACUFORM_CHECK(db.execute("BEGIN; SET LOCAL lock_timeout='2s'"));
  const auto changed = change_tables(db, version);
  const auto ended = db.execute(changed ? "COMMIT" : "ROLLBACK");
  return changed ? ended : changed;
}

}  // namespace vacuform
