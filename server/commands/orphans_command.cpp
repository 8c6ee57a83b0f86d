#include "server/commands/orphans_command.hpp"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"
#include "server/commands/ask_server.hpp"
#include "server/jobs/job_json.hpp"

namespace vacuform {

void OrphansCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand("orphans", "List or delete the objects in the bucket that no job knows");
  command_->add_option("--data", data_, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
  command_->add_flag("--delete", search_.remove, "Delete them");
  command_->add_option("--older-than", hours_, "Hours; younger objects are left out")
      ->type_name("HOURS")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 87600.0));
  command_
      ->add_option("--most", search_.most,
                   "Percent of all objects; more orphans, if they are also more than 20, are not deleted")
      ->type_name("PERCENT")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
}

bool OrphansCommand::asked() const { return command_->parsed(); }

Result<void> OrphansCommand::run(const std::filesystem::path& configured_data,
                                 const StoreOptions& places) const {
  const std::filesystem::path data = data_.empty() ? configured_data : data_;
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  if (!has_store(data)) return no_store(data);
  OrphanSearch search = search_;
  search.older_than = static_cast<Millis>(hours_ * 3'600'000);
  const auto find = [&]() -> Result<nlohmann::ordered_json> {
    const auto store = open_store(data, places);
    if (store) {
      VACUFORM_TRY(report, (*store)->orphans(search, [] { return true; }));
      return orphans_json(report);
    }
    if (store.error().code != Code::unavailable) return tl::make_unexpected(store.error());
    const nlohmann::json body = {
        {"delete", search.remove}, {"older_than_hours", hours_}, {"most_percent", search.most}};
    return ask_server(data, store.error(), "POST", "/api/v1/orphans", body.dump(), std::chrono::hours(12));
  };
  VACUFORM_TRY(report, find());
  std::printf("%s\n", report.dump().c_str());
  return {};
}

}  // namespace vacuform
