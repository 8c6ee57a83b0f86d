#include "worker/cli/outcome.hpp"

#include <cstdio>
#include <fstream>

#include "worker/inspection/summary.hpp"

namespace vacuform::cli {

OutcomeOptions::Added OutcomeOptions::add_to(CLI::App& command) {
  Added added{};
  added.json = command.add_flag("--json", json, "Print the summary as one JSON object on standard output");
  added.quiet =
      command.add_flag("--quiet", quiet, "Print neither progress nor summary")->excludes(added.json);
  added.strict = command.add_flag("--strict", strict, "Exit with 3 when the result has a serious warning");
  return added;
}

nlohmann::ordered_json read_report(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  auto report = nlohmann::ordered_json::parse(in, nullptr, false);
  return report.is_object() ? std::move(report) : nlohmann::ordered_json();
}

void tell(const OutcomeOptions& options, const nlohmann::ordered_json& report, const std::string& out) {
  if (options.quiet || !report.contains("figures")) return;
  const std::string text =
      options.json ? summary_json(report, out).dump(2) + "\n" : summary_text(report, out);
  std::fputs(text.c_str(), stdout);
}

int exit_code_of(const OutcomeOptions& options, const nlohmann::ordered_json& report) {
  return options.strict && serious_warnings(report) > 0 ? with_serious_warnings : 0;
}

}  // namespace vacuform::cli
