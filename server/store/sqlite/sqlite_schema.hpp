// The tables of the store, and the way from every released version to this one.
#pragma once

#include "server/store/sqlite/sqlite.hpp"

namespace vacuform {

extern const std::int64_t newest_schema;

// Makes the tables in an empty database, or changes those of an older version, in one transaction; up to an older
// version only to test what follows it. Errors: corrupt_file (not a store, or written by a newer version), unavailable.
Result<void> bring_up_to_date(Database& db, std::int64_t version = newest_schema);

}  // namespace vacuform
