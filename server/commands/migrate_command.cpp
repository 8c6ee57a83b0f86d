#include "server/commands/migrate_command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"

namespace vacuform {

void MigrateCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand("migrate",
                                "Bring the tables of the jobs up to date, as a server does when it starts");
  command_->add_option("--data", data_, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
}

bool MigrateCommand::asked() const { return command_->parsed(); }

Result<void> MigrateCommand::run(const std::filesystem::path& configured_data,
                                 const StoreOptions& places) const {
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  VACUFORM_TRY(store, open_store(data_.empty() ? configured_data : data_, places));
  VACUFORM_TRY(status, store->status());
  std::printf("%s\n", nlohmann::ordered_json{{"schema", status.schema}}.dump().c_str());
  return {};
}

}  // namespace vacuform
