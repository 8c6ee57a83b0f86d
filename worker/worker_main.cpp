// vacuform-worker: leases jobs from a server and runs them. It opens no store and needs a URL and a token, nothing else.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "api/version.hpp"
#include "worker/lease_loop.hpp"

namespace vacuform {
namespace {

int refuse(const Error& error) {
  std::fprintf(stderr, "vacuform-worker: %s\n", error.text().c_str());
  return meaning(error.code).exit_code;
}

// The first line of the file, so that a token never stands on a command line.
Result<std::string> read_token(const std::string& file) {
  std::ifstream in(file);
  std::string token;
  if (!std::getline(in, token) || token.empty())
    return fail(Code::unreadable, "the token cannot be read", file,
                "give a file with the worker token on its first line");
  return token;
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
  std::error_code ec;
  const auto here = std::filesystem::read_symlink("/proc/self/exe", ec).parent_path();
  loop.program = here / "vacuform";
  loop.name = default_name();
  loop.work = std::filesystem::temp_directory_path() / ("vacuform-worker-" + std::to_string(::geteuid()));
  app.add_option("--server", loop.server, "Address of the server")->required()->type_name("URL");
  app.add_option("--token-file", token_file, "File that holds the worker token")
      ->required()
      ->type_name("FILE");
  app.add_option("--name", loop.name, "Name of this worker in the server's log");
  app.add_option("--work", loop.work, "Folder for the jobs' private folders")->type_name("DIR");
  app.add_option("--poll-seconds", poll_seconds, "Pause between two questions for a job")
      ->check(CLI::Range(0.05, 3600.0));
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
#endif
  if (::access(loop.program.c_str(), X_OK) != 0)
    return refuse({Code::unreadable, "the program vacuform is not beside this one", loop.program.string(),
                   "install both in one folder"});
  const auto token = read_token(token_file);
  if (!token) return refuse(token.error());
  loop.token = *token;
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignal stop;
  const auto ran = loop.run(stop);
  return ran ? 0 : refuse(ran.error());
}

}  // namespace
}  // namespace vacuform

int main(int argc, char** argv) { return vacuform::run(argc, argv); }
