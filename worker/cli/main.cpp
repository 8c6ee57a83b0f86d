// vacuform: the command line.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "api/commit.hpp"
#include "api/problem.hpp"
#include "worker/cli/commands.hpp"

namespace vacuform::cli {

int refuse(const Error& error) {
  std::fprintf(stderr, "vacuform: %s\n", error.text().c_str());
  return meaning(error.code).exit_code;
}

Error out_of_memory() {
  return {Code::out_of_time, "there is not enough memory", "",
          "give a smaller scan, a coarser sheet.resolution_mm or a lower print.dpi"};
}

namespace {

// CLI11's complaint as one line that names the command to ask; `first` is the first word of the command line.
int refuse_usage(const CLI::App& app, const std::string& first, const CLI::ParseError& complaint) {
  std::string command = "vacuform";
  for (const CLI::App* sub : app.get_subcommands()) command += " " + sub->get_name();
  const bool no_such = app.get_subcommands().empty() && !first.empty() && first.front() != '-';
  return refuse({Code::bad_usage, no_such ? "no such command: " + first : complaint.what(), "",
                 "see " + command + " --help"});
}

int run(int argc, char** argv) {
  CLI::App app("Pre-distorted prints for vacuum-formed sheets: a scan and a pattern in, a print out.",
               "vacuform");
  app.set_version_flag("--version", version_line("vacuform"));
  app.require_subcommand(1);
  int exit_code = 0;
  add_run(app, exit_code);
  add_inspect(app, exit_code);
  add_layout(app, exit_code);
  add_sample(app, exit_code);
  add_submit(app, exit_code);
  add_converge(app, exit_code);
  add_calibrate(app, exit_code);
  add_chart(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& complaint) {
    return refuse_usage(app, argc > 1 ? argv[1] : "", complaint);
  }
  return exit_code;
}

}  // namespace
}  // namespace vacuform::cli

int main(int argc, char** argv) {
  using namespace vacuform;
  try {
    return cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return cli::refuse(cli::out_of_memory());
  } catch (const std::exception& fault) {
    return cli::refuse({Code::internal, std::string("internal fault: ") + fault.what(), "",
                        "please report it with the command that you gave"});
  }
}
