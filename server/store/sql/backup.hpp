// The copy of a store in use: the rows first, as they are at one moment, into a file of SQLite; then every blob that these
// rows name. Blobs never change, and the caller keeps all of them meanwhile.
#pragma once

#include <filesystem>
#include <functional>

#include "server/store/blob_store.hpp"
#include "server/store/sql.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// `copy_rows` writes the file; `done` notes that there is a backup. Errors as for Store::backup().
Result<BackupReport> make_backup(const std::filesystem::path& to, BlobStore& blobs,
                                 const std::function<Result<void>(const std::filesystem::path&)>& copy_rows,
                                 const std::function<bool()>& going,
                                 const std::function<Result<void>()>& done);

// The hashes of all blobs that the rows name, but for the pieces of unfinished uploads.
Result<std::vector<std::string>> named_hashes(Database& db);
// Gives the rows a number of their own, as those of no data folder yet (folder_mark.hpp).
Result<std::string> number_rows(Database& db);

}  // namespace vacuform
