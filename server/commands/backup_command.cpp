#include "server/commands/backup_command.hpp"

#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "api/base/secrets.hpp"
#include "server/commands/ask_server.hpp"
#include "server/jobs/job_json.hpp"

namespace vacuform {

void BackupCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand("backup", "Copy the jobs and their files, while the server runs");
  command_->add_option("--data", data_, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
  command_->add_option("--to", to_, "Folder for the copy: absent or empty")->required()->type_name("DIR");
}

bool BackupCommand::asked() const { return command_->parsed(); }

Result<void> BackupCommand::run(const std::filesystem::path& configured_data,
                                const StoreOptions& places) const {
  const std::filesystem::path data = data_.empty() ? configured_data : data_;
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  if (!has_store(data)) return no_store(data);
  const std::filesystem::path to = std::filesystem::absolute(to_);
  ::mkdir(to.c_str(), 0700);
  const auto make = [&]() -> Result<nlohmann::ordered_json> {
    const auto store = open_store(data, places);
    if (store) {
      VACUFORM_TRY(report, (*store)->backup(to, [] { return true; }));
      return backup_json(report);
    }
    if (store.error().code != Code::unavailable) return tl::make_unexpected(store.error());
    return ask_server(data, store.error(), "POST", "/api/v1/backup",
                      nlohmann::json{{"to", to.string()}}.dump(), std::chrono::hours(12));
  };
  VACUFORM_TRY(report, make());
  std::printf("%s\n", report.dump().c_str());
  if (report["damaged"].empty()) return {};
  return fail(Code::internal, "files were left out, since they are damaged: " + report["damaged"].dump(),
              to.string(), "find the jobs that name them by their hashes, or take an older backup");
}

}  // namespace vacuform
