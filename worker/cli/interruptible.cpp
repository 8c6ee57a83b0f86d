#include "worker/cli/interruptible.hpp"

#include <csignal>
#include <cstdio>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/problem.hpp"
#include "worker/cli/commands.hpp"

namespace vacuform::cli {

namespace {

std::optional<Context> running;  // for the signal handler
extern "C" void cancel_work(int) {
  if (running) running->cancel();
}

void say(const nlohmann::json& line) {
  std::printf("%s\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

}  // namespace

CLI::Option* add_progress_option(CLI::App& command, ProgressAs& into) {
  return command.add_option("--progress", into, "A bar on a terminal, or JSON lines on standard output")
      ->transform(CLI::Transformer(
          std::map<std::string, ProgressAs>{{"bar", ProgressAs::bar}, {"json", ProgressAs::json}}));
}

int run_interruptible(const std::function<Result<void>(const Context&, ProgressBar&)>& work,
                      ProgressAs progress) {
  ProgressBar bar(ProgressBar::Otherwise::silent);
  running.emplace([&](Stage stage, double fraction) {
    if (progress == ProgressAs::json)
      say({{"stage", name(stage)}, {"progress", fraction}});
    else if (progress == ProgressAs::bar)
      bar.show(stage, fraction);
  });
  struct sigaction action {};
  action.sa_handler = cancel_work;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  const auto done = [&]() -> Result<void> {
    try {
      return work(*running, bar);
    } catch (const std::bad_alloc&) {
      return tl::make_unexpected(out_of_memory());
    }
  }();
  bar.clear();
  if (done) return 0;
  const Error& error = done.error();
  if (progress == ProgressAs::json)
    say({{"problem",
          {{"code", meaning(error.code).slug},
           {"what", error.what},
           {"where", error.where},
           {"fix", error.fix},
           {"proposals", proposals_json(error.proposals)}}}});
  return refuse(error);
}

StageCache stage_cache(const std::string& folder, ProgressAs progress) {
  if (folder.empty()) return {};
  return StageCache(folder, [progress](Stage stage) {
    if (progress == ProgressAs::json) say({{"stage", name(stage)}, {"progress", 1}, {"cached", true}});
  });
}

}  // namespace vacuform::cli
