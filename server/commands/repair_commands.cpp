#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/commands/store_command.hpp"
#include "server/store/blobs/s3/s3_address.hpp"
#include "server/store/sql/repair.hpp"

namespace vacuform {

namespace {

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

class VerifyCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command =
        add(app, "verify", "Look for damage in the jobs and their files, of a stopped server");
    add_data(command);
    command.add_flag("--read-data", read_, "Read the files too, and compare their bytes with their hashes");
    command.add_flag("--repair", repair_,
                     "Rewrite a damaged database, and move what is damaged or belongs to no job to "
                     "DATA/quarantine");
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
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

  bool read_ = false, repair_ = false;
};

class RestoreCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command = add(app, "restore", "Put a backup in the place of the jobs of a stopped server");
    add_data(command);
    command.add_option("--from", from_, "Folder that vacuform-server backup has written")
        ->required()
        ->type_name("DIR");
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    if (!places.database.empty() || !blobs_in_files(places.blobs))
      return fail(
          Code::bad_usage, "a backup is restored into a folder", "--store",
          "restore it with --data into an empty folder, and copy that with vacuform-server copy-store");
    VACUFORM_TRY(report, restore_backup(from_, data));
    print({{"jobs", report.jobs}, {"files", report.files}, {"damaged", report.damaged}});
    if (report.damaged.empty()) return {};
    return fail(Code::internal, "files are missing in the backup, or damaged there", from_.string(),
                "look for them in an older backup; vacuform-server verify names them");
  }

  std::filesystem::path from_;
};

class AdoptCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command =
        add(app, "adopt",
            "Say that the database and the data folder belong together from now on, of a stopped server");
    add_data(command);
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    StoreOptions options = places;
    options.adopt = true;
    VACUFORM_TRY(store, open_store(data, options));
    VACUFORM_TRY(found, store->check(false, [](std::uint64_t) { return true; }));
    print(check_json(found));
    return {};
  }
};

}  // namespace

StoreCommandPointer verify_command() { return std::make_unique<VerifyCommand>(); }
StoreCommandPointer restore_command() { return std::make_unique<RestoreCommand>(); }
StoreCommandPointer adopt_command() { return std::make_unique<AdoptCommand>(); }

}  // namespace vacuform
