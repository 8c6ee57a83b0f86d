#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/commands/store_command.hpp"

namespace vacuform {

namespace {

class MigrateCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command =
        add(app, "migrate", "Bring the tables of the jobs up to date, as a server does when it starts");
    add_data(command);
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    VACUFORM_TRY(store, open_store(data, places));
    VACUFORM_TRY(status, store->status());
    std::printf("%s\n", nlohmann::ordered_json{{"schema", status.schema}}.dump().c_str());
    return {};
  }
};

}  // namespace

StoreCommandPointer migrate_command() { return std::make_unique<MigrateCommand>(); }

}  // namespace vacuform
