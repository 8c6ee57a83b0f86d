#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/commands/ask_server.hpp"
#include "server/commands/store_command.hpp"
#include "server/jobs/job_json.hpp"

namespace vacuform {

namespace {

class OrphansCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command = add(app, "orphans", "List or delete the objects in the bucket that no job knows");
    add_data(command);
    command.add_flag("--delete", search_.remove, "Delete them");
    command.add_option("--older-than", hours_, "Hours; younger objects are left out")
        ->type_name("HOURS")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 87600.0));
    command
        .add_option("--most", search_.most,
                    "Percent of all objects; more orphans, if they are also more than 20, are not deleted")
        ->type_name("PERCENT")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 100.0));
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    if (!has_store(data)) return no_store(data);
    OrphanSearch search = search_;
    search.older_than = static_cast<Millis>(hours_ * 3'600'000);
    const auto here = [&](Store& store) -> Result<nlohmann::ordered_json> {
      VACUFORM_TRY(report, store.orphans(search, [] { return true; }));
      return orphans_json(report);
    };
    const nlohmann::json body = {
        {"delete", search.remove}, {"older_than_hours", hours_}, {"most_percent", search.most}};
    VACUFORM_TRY(report, do_or_ask(data, places, here, "POST", "/api/v1/orphans", body.dump(),
                                   std::chrono::hours(12)));
    std::printf("%s\n", report.dump().c_str());
    return {};
  }

  OrphanSearch search_;
  double hours_ = 48;
};

}  // namespace

StoreCommandPointer orphans_command() { return std::make_unique<OrphansCommand>(); }

}  // namespace vacuform
