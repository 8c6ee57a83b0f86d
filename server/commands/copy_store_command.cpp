#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/commands/store_command.hpp"
#include "server/store/sql/copy_store.hpp"

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

class CopyStoreCommand final : public StoreCommand {
 public:
  void add_to(CLI::App& app) override {
    CLI::App& command =
        add(app, "copy-store", "Copy the jobs and their files of a stopped server to another place");
    add_data(command);
    command.add_option("--to", to_, "Data folder of the copy, without jobs")->required()->type_name("DIR");
    command
        .add_option("--to-store", target_.database,
                    "PostgreSQL database for the jobs of the copy, as for --store (default: SQLite in --to)")
        ->type_name("URL");
    command
        .add_option("--to-blobs", target_.blobs,
                    "Object store for scans and results of the copy, as for --blobs (default: files in --to)")
        ->type_name("URL");
    command
        .add_option("--to-blobs-credentials", target_.blobs_credentials,
                    "File with the access key for --to-blobs (default: the environment)")
        ->type_name("FILE");
  }

 private:
  Result<void> run_on(const std::filesystem::path& data, const StoreOptions& places) override {
    const StorePlace from{data, places}, to{to_, target_};
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

  std::filesystem::path to_;
  StoreOptions target_;
};

}  // namespace

StoreCommandPointer copy_store_command() { return std::make_unique<CopyStoreCommand>(); }

}  // namespace vacuform
