// vacuform-worker: leases jobs from a server and runs them. It opens no store and needs a URL and a token, nothing else.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "api/version.hpp"
#include "worker/configuration.hpp"

namespace vacuform {
namespace {

// Until a signal ends it.
Result<void> work(const WorkerConfiguration& configuration) {
  VACUFORM_TRY(loop, configuration.loop());
  bool sandbox = !configuration.no_sandbox;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  loop.limits.address_space = 0;  // their shadow memory takes terabytes of addresses
  sandbox = false;                // and their checks look into /proc and at other threads
#endif
  if (sandbox) loop.sandbox = Sandbox::of_this_machine();
  if (!configuration.no_keep) {
    constexpr std::uint64_t most_kept = 2'000'000'000;  // bytes
    const auto folder = configuration.keep.empty() ? loop.work / "kept" : configuration.keep;
    VACUFORM_TRY(kept, KeptScans::open(std::filesystem::absolute(folder), most_kept,
                                       std::chrono::hours(24 * configuration.keep_days)));
    loop.kept = std::move(kept);
  }
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignal stop;
  return loop.run(stop);
}

Result<void> run(ConfigurationSources& sources, const WorkerConfiguration& configuration, int argc,
                 char** argv) {
  VACUFORM_CHECK(sources.read(argc, argv));
  if (!sources.only_check()) return work(configuration);
  VACUFORM_CHECK(configuration.loop());
  std::printf("%s\n", sources.text().c_str());
  return {};
}

}  // namespace
}  // namespace vacuform

int main(int argc, char** argv) {
  CLI::App app("Leases jobs from a Vacuform server and runs them.", "vacuform-worker");
  app.set_version_flag("--version", std::string("vacuform-worker ").append(vacuform::version));
  vacuform::ConfigurationSources sources(app, "worker");
  vacuform::WorkerConfiguration configuration;
  configuration.add_to(sources);
  try {
    const auto done = vacuform::run(sources, configuration, argc, argv);
    if (done) return 0;
    std::fprintf(stderr, "vacuform-worker: %s\n", done.error().text().c_str());
    return vacuform::meaning(done.error().code).exit_code;
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "vacuform-worker: internal fault: %s\n", fault.what());
    return 1;
  }
}
