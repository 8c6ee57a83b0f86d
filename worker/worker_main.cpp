// vacuform-worker: leases jobs from a server and runs them. It opens no store and needs a URL and a token, nothing else.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdio>

#include "api/token.hpp"
#include "api/version.hpp"
#include "worker/lease_loop.hpp"

namespace vacuform {
namespace {

int refuse(const Error& error) {
  std::fprintf(stderr, "vacuform-worker: %s\n", error.text().c_str());
  return meaning(error.code).exit_code;
}

std::string default_name() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  return std::string(host) + "-" + std::to_string(::getpid());
}

int run(int argc, char** argv) {
  CLI::App app("Leases jobs from a Vacuform server and runs them.", "vacuform-worker");
  app.set_version_flag("--version", "vacuform-worker " + std::string(version));
  LeaseLoop loop;
  std::string token_file;
  double poll_seconds = 1;
  bool no_sandbox = false, no_keep = false;
  std::filesystem::path keep;
  int keep_days = 7;
  std::error_code ec;
  const auto here = std::filesystem::read_symlink("/proc/self/exe", ec).parent_path();
  loop.program = here / "vacuform";
  loop.name = default_name();
  loop.work = std::filesystem::temp_directory_path() / ("vacuform-worker-" + std::to_string(::geteuid()));
  app.add_option("--server", loop.server, "Address of the server")->required()->type_name("URL");
  app.add_option("--token-file", token_file,
                 "File that holds a token of the scope work (default: VACUFORM_TOKEN, or the file that "
                 "VACUFORM_TOKEN_FILE names)")
      ->type_name("FILE");
  app.add_option("--name", loop.name, "Name of this worker in the server's log");
  app.add_option("--work", loop.work, "Folder for the jobs' private folders")->type_name("DIR");
  app.add_option("--poll-seconds", poll_seconds, "Pause between two questions for a job")
      ->check(CLI::Range(0.05, 3600.0));
  app.add_option(
         "--keep", keep,
         "Folder for what scan and forming made, so that another job of the same scan skips them; it holds "
         "heads (default: kept in the folder of --work)")
      ->type_name("DIR");
  app.add_option("--keep-days", keep_days, "Days after the last use for which a scan's stages are kept")
      ->check(CLI::Range(1, 3650))
      ->capture_default_str();
  app.add_flag("--no-keep", no_keep, "Keep nothing of a job");
  app.add_flag("--no-sandbox", no_sandbox,
               "Run jobs with the rights of this user, for finding faults; never for files of others");
  // For service units: --poll-seconds is VACUFORM_WORKER_POLL_SECONDS too, and weaker.
  for (CLI::Option* option : app.get_options()) {
    std::string name = option->get_single_name();
    if (name == "help" || name == "version") continue;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c == '-' ? '_' : static_cast<char>(std::toupper(c)); });
    option->envname("VACUFORM_WORKER_" + name);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& complaint) {
    return refuse({Code::bad_usage, complaint.what(), "", "see vacuform-worker --help"});
  }
  loop.poll = std::chrono::milliseconds(static_cast<int>(poll_seconds * 1000));
  loop.work = std::filesystem::absolute(loop.work);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  loop.limits.address_space = 0;  // their shadow memory takes terabytes of addresses
  no_sandbox = true;              // and their checks look into /proc and at other threads
#endif
  if (!no_sandbox) loop.sandbox = Sandbox::of_this_machine();
  if (::access(loop.program.c_str(), X_OK) != 0)
    return refuse({Code::unreadable, "the program vacuform is not beside this one", loop.program.string(),
                   "install both in one folder"});
  if (!no_keep) {
    constexpr std::uint64_t most_kept = 2'000'000'000;  // bytes
    auto kept = KeptScans::open(std::filesystem::absolute(keep.empty() ? loop.work / "kept" : keep),
                                most_kept, std::chrono::hours(24 * keep_days));
    if (!kept) return refuse(kept.error());
    loop.kept = *std::move(kept);
  }
  const auto token = find_token(token_file);
  if (!token) return refuse(token.error());
  if (token->empty())
    return refuse({Code::bad_usage, "there is no token", "--token-file",
                   "give a file that holds a token of the scope work, or set VACUFORM_TOKEN_FILE"});
  loop.token = *token;
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignal stop;
  const auto ran = loop.run(stop);
  return ran ? 0 : refuse(ran.error());
}

}  // namespace
}  // namespace vacuform

int main(int argc, char** argv) { return vacuform::run(argc, argv); }
