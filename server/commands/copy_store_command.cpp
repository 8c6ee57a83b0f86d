#include "server/commands/copy_store_command.hpp"

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"
#include "server/store/copy_store.hpp"

namespace vacuform {

namespace {

std::atomic<bool> copy_cancelled{false};
static_assert(std::atomic<bool>::is_always_lock_free);
extern "C" void cancel_copy(int) { copy_cancelled = true; }

// The first signal cancels, the next one kills.
void cancel_on_signals() {
  struct sigaction action {};
  action.sa_handler = cancel_copy;
  action.sa_flags = SA_RESETHAND;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

// Once a second.
class ShownCopy {
 public:
  void show(const CopyProgress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + std::chrono::seconds(1);
    constexpr double mebibyte = 1 << 20;
    if (progress.rows > 0)
      std::fprintf(stderr, "%s %lld rows\n", progress.step, static_cast<long long>(progress.rows));
    else
      std::fprintf(stderr, "%s %lld of %lld files, %.0f of %.0f MiB\n", progress.step,
                   static_cast<long long>(progress.blobs), static_cast<long long>(progress.all_blobs),
                   static_cast<double>(progress.bytes) / mebibyte,
                   static_cast<double>(progress.all_bytes) / mebibyte);
  }

 private:
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
};

}  // namespace

void CopyStoreCommand::add_to(CLI::App& app) {
  command_ =
      app.add_subcommand("copy-store", "Copy the jobs and their files of a stopped server to another place");
  command_->add_option("--data", data_, "Folder of the jobs (default: as the server's settings say)")
      ->type_name("DIR");
  command_->add_option("--to", to_, "Data folder of the copy, without jobs")->required()->type_name("DIR");
  command_
      ->add_option("--to-store", target_.database,
                   "PostgreSQL database for the jobs of the copy, as for --store (default: SQLite in --to)")
      ->type_name("URL");
  command_
      ->add_option("--to-blobs", target_.blobs,
                   "Object store for scans and results of the copy, as for --blobs (default: files in --to)")
      ->type_name("URL");
  command_
      ->add_option("--to-blobs-credentials", target_.blobs_credentials,
                   "File with the access key for --to-blobs (default: the environment)")
      ->type_name("FILE");
}

bool CopyStoreCommand::asked() const { return command_->parsed(); }

Result<void> CopyStoreCommand::run(const std::filesystem::path& configured_data,
                                   const StoreOptions& places) const {
  const StorePlace from{data_.empty() ? configured_data : data_, places}, to{to_, target_};
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  cancel_on_signals();
  ShownCopy shown;
  VACUFORM_TRY(report, copy_store(
                           from, to, [] { return !copy_cancelled; },
                           [&](const CopyProgress& progress) { shown.show(progress); }));
  const nlohmann::ordered_json damaged = report.damaged;
  std::printf(
      "%s\n",
      nlohmann::ordered_json{
          {"jobs", report.jobs}, {"files", report.blobs}, {"bytes", report.bytes}, {"damaged", damaged}}
          .dump()
          .c_str());
  if (damaged.empty()) return {};
  return fail(
      Code::internal, "files were left out, since they are damaged: " + damaged.dump(), to_.string(),
      "find the jobs that name them by their hashes, or restore these files from a backup and copy again");
}

}  // namespace vacuform
