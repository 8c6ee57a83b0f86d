// The subcommands of vacuform-server that work on what a data folder holds, and end.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class StoreCommand {
 public:
  virtual ~StoreCommand() = default;
  virtual void add_to(CLI::App& app) = 0;
  bool asked() const;
  // `configured_data` is the data folder if --data is absent, `places` says what is stored elsewhere. Errors: internal
  // (no random numbers), those of the command.
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places);

 protected:
  // Adds the subcommand.
  CLI::App& add(CLI::App& app, const std::string& name, const std::string& help);
  void add_data(CLI::App& command);  // --data
  bool data_named() const { return !data_.empty(); }
  virtual Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) = 0;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_;
};

using StoreCommandPointer = std::unique_ptr<StoreCommand>;

// Tokens, for users who may read the data folder. A new token is printed once, or written to a file that only its owner can
// read. Errors: bad_usage, not_found, unauthorized (the administrator's token is missing or was revoked).
StoreCommandPointer token_command();
// A copy of the data folder, from which a server can start. Errors: bad_usage (the folder is not empty), unavailable,
// internal (something was left out, being damaged).
StoreCommandPointer backup_command();
// The objects in the bucket that no row knows: lists or deletes them. Errors: those of Store::orphans().
StoreCommandPointer orphans_command();
// These three ask the server if one runs, since only the process that owns the store may touch it. Those below are for a
// stopped server.

// Puts a backup in the place of the jobs. Errors: those of restore_backup(); bad_usage, if the jobs or their files are not in
// the folder.
StoreCommandPointer restore_command();
// Looks for damage. Errors: internal, if something is damaged.
StoreCommandPointer verify_command();
// Binds a folder and a database to each other.
StoreCommandPointer adopt_command();
// Moves everything, such as from SQLite and files to PostgreSQL and an object store. Shows its progress on standard error;
// SIGINT and SIGTERM cancel it. Errors: those of copy_store(); internal (something was left out, being damaged).
StoreCommandPointer copy_store_command();
// Brings the tables of the jobs up to date, as a server does when it starts.
StoreCommandPointer migrate_command();

}  // namespace vacuform
