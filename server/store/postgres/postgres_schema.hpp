// The tables in PostgreSQL, in the first schema of the connection's search_path. Those that SQLite has, too, have the same
// names and columns (schema-1.sql of both), so that the same statements work on both and a copy needs no translation.
#pragma once

#include <span>
#include <string>

#include "server/store/sql.hpp"

namespace vacuform {

extern const std::int64_t newest_postgres_schema;

// Makes the tables in an empty database, or changes those of an older version; up to an older version only to test what
// follows it. Servers that start at the same moment take turns. Gives up waiting for a lock of a table after two seconds, so that it stops nobody, and then may be called again.
// Errors: corrupt_file (written by a newer version), unavailable.
Result<void> bring_postgres_up_to_date(Database& db, std::int64_t version = newest_postgres_schema);

// The tables that a copy contains, after those that they refer to.
struct CopiedTable {
  const char* name;
  const char* columns;         // "a, b, c"
  int real = 0;                // the column with floating-point numbers, from 1; 0: none
  const char* moved = "true";  // the rows that belong to the store wherever its rows and blobs are
};
// An insertion of one row.
std::string insertion(const CopiedTable& table);
std::span<const CopiedTable> copied_tables();

}  // namespace vacuform
