#include "worker/agent/configuration.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>

#include "api/client/http.hpp"
#include "api/client/token.hpp"

namespace vacuform {

namespace {

std::string default_name() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  return std::string(host) + "-" + std::to_string(::getpid());
}

}  // namespace

void WorkerConfiguration::add_to(ConfigurationSources& sources) {
  name = default_name();
  work = std::filesystem::temp_directory_path() / ("vacuform-worker-" + std::to_string(::geteuid()));
  sources.add("server", &server, "Address of the server, http://... or https://...")->type_name("URL");
  sources
      .add("token_file", &token_file,
           "File that holds a token of the scope work (default: VACUFORM_TOKEN, or the file that "
           "VACUFORM_TOKEN_FILE names)")
      ->type_name("FILE");
  sources.add("name", &name, "Name of this worker in the server's log");
  sources.add("work", &work, "Folder for the jobs' private folders")->type_name("DIR");
  sources.add("poll_seconds", &poll_seconds, "Pause between two requests for a job")
      ->check(CLI::Range(0.05, 3600.0));
  sources
      .add("drain", &drain,
           "Time that the running job has to end after SIGTERM; then it goes back to the queue, without a "
           "failed attempt")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 86400.0));
  sources.add("max_jobs", &max_jobs, "Exit after so many jobs; 0: no limit")
      ->type_name("N")
      ->check(CLI::Range(0, 1000000));
  sources.add("idle_exit", &idle_exit, "Exit when the server has had no job for so long; 0: never")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 86400.0));
  sources
      .add("cache", &cache,
           "Folder for what scan and forming made, so that another job of the same scan skips them; it holds "
           "heads (default: cache in the folder of --work)")
      ->type_name("DIR");
  sources.add("cache_days", &cache_days, "Days after the last use for which the stages of a scan are cached")
      ->check(CLI::Range(1, 3650));
  sources.add("no_cache", &no_cache, "Cache nothing of a job");
  sources
      .add("sandbox", &sandbox,
           "required: stop unless the kernel gives Landlock and seccomp; best-effort: run jobs with the "
           "measures that "
           "it gives; off: run them with all rights of this user, to find faults, never for files of others")
      ->check(CLI::IsMember({"required", "best-effort", "off"}));
  sources
      .add(
          "user", &user,
          "User to become, when started by root: jobs then cannot read what belongs to root or to the server")
      ->type_name("NAME");
}

Result<LeaseLoop> WorkerConfiguration::loop() const {
  if (server.empty())
    return fail(Code::bad_usage, "there is no server", "--server", "give for example http://127.0.0.1:8080");
  LeaseLoop loop;
  loop.server = server;
  loop.name = name;
  loop.poll = std::chrono::milliseconds(static_cast<int>(poll_seconds * 1000));
  if (max_jobs > 0) loop.most_jobs = max_jobs;
  if (idle_exit > 0) loop.idle_exit = std::chrono::milliseconds(std::lround(1000 * idle_exit));
  loop.program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "vacuform";
  loop.program_file = Descriptor(::open(loop.program.c_str(), O_PATH | O_CLOEXEC));
  if (!loop.program_file || ::access(loop.program.c_str(), X_OK) != 0)
    return fail(Code::unreadable, "the program vacuform is not beside this one", loop.program.string(),
                "install both in one folder");
  VACUFORM_TRY(token, find_token(token_file.string()));
  if (token.empty())
    return fail(Code::bad_usage, "there is no token", "--token-file",
                "give a file that holds a token of the scope work, or set VACUFORM_TOKEN_FILE");
  loop.token = token;
  VACUFORM_CHECK(Http::to(server, token));
  return loop;
}

}  // namespace vacuform
