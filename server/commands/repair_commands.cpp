#include "server/commands/repair_commands.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"
#include "server/store/repair.hpp"
#include "server/store/s3_address.hpp"

namespace vacuform {

namespace {

void add_data(CLI::App& command, std::filesystem::path& data) {
  command.add_option("--data", data, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
}

void print(const nlohmann::ordered_json& report) { std::printf("%s\n", report.dump().c_str()); }

nlohmann::ordered_json check_json(const StoreCheck& found) {
  return {{"pages", found.pages.empty() ? "good" : found.pages},
          {"jobs", found.jobs},
          {"files", found.files},
          {"bytes_read", found.bytes},
          {"damaged_jobs", found.damaged_jobs},
          {"damaged_files", found.damaged_files},
          {"missing_files", found.missing_files},
          {"files_without_job", found.unnamed.size()},
          {"bytes_without_job", found.unnamed_bytes}};
}

}  // namespace

void VerifyCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand("verify", "Look for damage in the jobs and their files, of a stopped server");
  add_data(*command_, data_);
  command_->add_flag("--read-data", read_, "Read the files too, and compare their bytes with their hashes");
  command_->add_flag("--repair", repair_,
                     "Rewrite a damaged database, and move what is damaged or belongs to no job to "
                     "DATA/quarantine");
}

bool VerifyCommand::asked() const { return command_->parsed(); }

Result<void> VerifyCommand::run(const std::filesystem::path& configured_data,
                                const StoreOptions& places) const {
  const std::filesystem::path data = data_.empty() ? configured_data : data_;
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  if (!has_store(data)) return no_store(data);
  if (repair_ && places.database.empty()) {
    VACUFORM_TRY(written, repair_pages(data));
    if (written) std::fprintf(stderr, "the database is rewritten; the old one is in quarantine\n");
  }
  VACUFORM_TRY(store, open_store(data, places));
  VACUFORM_TRY(found, store->check(read_, [](std::uint64_t) { return true; }));
  print(check_json(found));
  if (repair_) return set_damage_in_quarantine(data, *store, found);
  if (found.good()) return {};
  return fail(Code::internal, "something is damaged or missing", data.string(),
              "restore a backup with vacuform-server restore, or move it out of the way with --repair");
}

void RestoreCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand("restore", "Put a backup in the place of the jobs of a stopped server");
  add_data(*command_, data_);
  command_->add_option("--from", from_, "Folder that vacuform-server backup has written")
      ->required()
      ->type_name("DIR");
}

bool RestoreCommand::asked() const { return command_->parsed(); }

Result<void> RestoreCommand::run(const std::filesystem::path& configured_data,
                                 const StoreOptions& places) const {
  const std::filesystem::path data = data_.empty() ? configured_data : data_;
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  if (!places.database.empty() || !blobs_in_files(places.blobs))
    return fail(Code::bad_usage, "a backup is restored into a folder", "--store",
                "restore it with --data into an empty folder, and copy that with vacuform-server copy-store");
  VACUFORM_TRY(report, restore_backup(from_, data));
  print({{"jobs", report.jobs}, {"files", report.files}, {"damaged", report.damaged}});
  if (report.damaged.empty()) return {};
  return fail(Code::internal, "files are missing in the backup, or damaged there", from_.string(),
              "look for them in an older backup; vacuform-server verify names them");
}

void AdoptCommand::add_to(CLI::App& app) {
  command_ = app.add_subcommand(
      "adopt", "Say that the database and the data folder belong together from now on, of a stopped server");
  add_data(*command_, data_);
}

bool AdoptCommand::asked() const { return command_->parsed(); }

Result<void> AdoptCommand::run(const std::filesystem::path& configured_data,
                               const StoreOptions& places) const {
  StoreOptions options = places;
  options.adopt = true;
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  VACUFORM_TRY(store, open_store(data_.empty() ? configured_data : data_, options));
  VACUFORM_TRY(found, store->check(false, [](std::uint64_t) { return true; }));
  print(check_json(found));
  return {};
}

}  // namespace vacuform
