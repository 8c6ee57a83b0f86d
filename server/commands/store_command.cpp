#include "server/commands/store_command.hpp"

#include <CLI/CLI.hpp>

#include "api/base/secrets.hpp"

namespace vacuform {

bool StoreCommand::asked() const { return command_->parsed(); }

Result<void> StoreCommand::run(const std::filesystem::path& configured_data, const StoreOptions& places) {
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  return run_on(data_named() ? data_ : configured_data, places);
}

CLI::App& StoreCommand::add(CLI::App& app, const std::string& name, const std::string& help) {
  command_ = app.add_subcommand(name, help);
  return *command_;
}

void StoreCommand::add_data(CLI::App& command) {
  command.add_option("--data", data_, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
}

}  // namespace vacuform
