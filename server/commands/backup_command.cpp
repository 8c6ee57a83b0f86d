#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "server/commands/ask_server.hpp"
#include "server/commands/store_command.hpp"
#include "server/jobs/job_json.hpp"

namespace vacuform {

namespace {

class BackupCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command = add(app, "backup", "Copy the jobs and their files, while the server runs");
    add_data(command);
    command.add_option("--to", to_, "Folder for the copy: absent or empty")->required()->type_name("DIR");
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    if (!has_store(data)) return no_store(data);
    const std::filesystem::path to = std::filesystem::absolute(to_);
    ::mkdir(to.c_str(), 0700);
    const auto here = [&](Store& store) -> Result<nlohmann::ordered_json> {
      VACUFORM_TRY(report, store.backup(to, [] { return true; }));
      return backup_json(report);
    };
    VACUFORM_TRY(report, do_or_ask(data, places, here, "POST", "/api/v1/backup",
                                   nlohmann::json{{"to", to.string()}}.dump(), std::chrono::hours(12)));
    std::printf("%s\n", report.dump().c_str());
    if (report["damaged"].empty()) return {};
    return fail(Code::internal, "files were left out, since they are damaged: " + report["damaged"].dump(),
                to.string(), "find the jobs that name them by their hashes, or take an older backup");
  }

  std::filesystem::path to_;
};

}  // namespace

StoreCommandPointer backup_command() { return std::make_unique<BackupCommand>(); }

}  // namespace vacuform
