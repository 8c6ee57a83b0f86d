// vacuform-worker: leases jobs from a server and runs them. It opens no store and needs a URL and a token, nothing else.
#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/commit.hpp"
#include "api/problem.hpp"
#include "worker/agent/configuration.hpp"
#include "worker/agent/user.hpp"
#include "worker/agent/work_folder.hpp"

namespace vacuform {
namespace {

// The sandbox that the setting asks for, in the order of how it is to be fixed: what the program needs first.
Result<Sandbox> choose_sandbox(const LeaseLoop& loop, const std::string& setting) {
  if (setting == "off") return Sandbox();
  VACUFORM_TRY(folder, WorkFolder::make(loop.work));
  if (::faccessat(loop.program_file.number(), "", X_OK, AT_EMPTY_PATH | AT_EACCESS) != 0)
    return fail(Code::unreadable, "the worker's user may not execute the program", loop.program.string(),
                "let every user read and execute it: chmod a+rx");
  const Sandbox found =
      strongest_sandbox(loop.program_file.number(), loop.program.string(), folder.path(), loop.limits);
  if (found.is_enough() || setting == "best-effort") return found;
  std::string lacks;
  for (const std::string& measure : found.measures(false))
    if (measure != "namespaces") lacks.append(lacks.empty() ? "" : " and ").append(measure);
  return fail(Code::bad_usage, "this machine lacks " + lacks + ", without which no job runs", "--sandbox",
              "use a kernel with Landlock (5.13 or newer, in the list of /sys/kernel/security/lsm) and a "
              "container that allows "
              "Landlock and seccomp; or set sandbox to best-effort, if you trust every file that is sent");
}

// Until a signal, --max-jobs or --idle-exit ends it.
Result<void> work(const WorkerConfiguration& configuration) {
  VACUFORM_TRY(loop, configuration.loop());
  std::string sandbox = configuration.sandbox;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  loop.limits.address_space = 0;  // their shadow memory takes terabytes of addresses
  sandbox = "off";                // and their checks look into /proc and at other threads
#endif
  const auto cache = configuration.cache.empty() ? "cache" : std::filesystem::absolute(configuration.cache);
  VACUFORM_CHECK(settle(std::filesystem::absolute(configuration.work), configuration.user));
  // The token is in this process's memory: no other process of this user may look into it.
  ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
  VACUFORM_TRY(swept, sweep(loop.work));
  if (swept > 0) log_event("work-folders-swept", {{"worker", loop.name}, {"folders", swept}});
  VACUFORM_TRY(chosen, choose_sandbox(loop, sandbox));
  loop.sandbox = chosen;
  loop.groups = JobGroups::delegated();
  // Without Landlock a job could read the caches of others.
  if (!configuration.no_cache && (chosen.landlock > 0 || sandbox == "off")) {
    constexpr std::uint64_t most_cached = 2'000'000'000;  // bytes
    VACUFORM_TRY(caches,
                 ScanCaches::open(cache, most_cached, std::chrono::hours(24 * configuration.cache_days)));
    loop.caches = std::move(caches);
  }
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignal stop(std::chrono::milliseconds(std::lround(1000 * configuration.drain)));
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
  app.set_version_flag("--version", vacuform::version_line("vacuform-worker"));
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
