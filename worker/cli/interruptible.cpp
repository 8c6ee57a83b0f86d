#include "worker/cli/interruptible.hpp"

#include <csignal>
#include <new>
#include <optional>

#include "worker/cli/commands.hpp"

namespace vacuform::cli {

namespace {

std::optional<Context> running;  // for the signal handler
extern "C" void cancel_work(int) {
  if (running) running->cancel();
}

}  // namespace

int run_interruptible(const std::function<Result<void>(const Context&, ProgressBar&)>& work) {
  ProgressBar bar(ProgressBar::Otherwise::silent);
  running.emplace([&](Stage stage, double fraction) { bar.show(stage, fraction); });
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
  return done ? 0 : refuse(done.error());
}

}  // namespace vacuform::cli
