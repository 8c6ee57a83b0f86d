// vacuform converge: how much the formed sheet depends on the spacing of its grid.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/study_options.hpp"
#include "worker/studies/convergence.hpp"

namespace vacuform::cli {

namespace {

struct ConvergeOptions {
  StudyOptions study;
  std::string out;
  bool twice = false, quarter = false;
};

void print(const Convergence& convergence) {
  std::printf("distance between the same points of the sheet, mm\n");
  std::printf("%-18s %-6s %8s %8s %8s %8s\n", "grid", "on", "mean", "95 %", "99 %", "max");
  for (const Refinement& r : convergence.refinements) {
    const std::string grid = short_decimal(r.coarse_mm) + " -> " + short_decimal(r.fine_mm) + " mm";
    const auto line = [&](const char* title, const char* where, const DistanceStatistics& s) {
      std::printf("%-18s %-6s %8.3f %8.3f %8.3f %8.3f\n", title, where, s.mean, s.p95, s.p99, s.max);
    };
    line(grid.c_str(), "head", r.head);
    line("", "sheet", r.sheet);
    std::printf("%-18s worst on the head at x %.1f, y %.1f, z %.1f (s %.1f, t %.1f), slope %.0f degrees\n",
                "", r.worst_formed.x(), r.worst_formed.y(), r.worst_formed.z(), r.worst_rest.x(),
                r.worst_rest.y(), r.worst_degrees);
  }
  if (convergence.order) std::printf("order of convergence %.2f (mean on the head)\n", *convergence.order);
}

Result<void> converge_scan(const ConvergeOptions& o, const Context& context, ProgressBar& bar) {
  VACUFORM_TRY(study, o.study.read());
  std::vector<double> factors;
  if (o.twice) factors.push_back(2);
  factors.insert(factors.end(), {1, 0.5});
  if (o.quarter) factors.push_back(0.25);
  for (const double factor : factors) {  // every grid must be valid in the settings
    nlohmann::json changed = to_json(study.settings);
    changed["sheet"]["resolution_mm"] = factor * study.settings.sheet.resolution_mm;
    VACUFORM_CHECK(settings_from_json(changed));
  }
  VACUFORM_TRY(prepared, prepare(study.scan, study.settings, study.temperature, context));
  VACUFORM_TRY(convergence, converge(prepared, study.settings, factors, context));
  bar.clear();
  print(convergence);
  if (o.out.empty()) return {};
  return write_json(o.out, json_of(convergence));
}

}  // namespace

void add_converge(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ConvergeOptions>();
  CLI::App* command = app.add_subcommand(
      "converge", "Say how far the formed sheet moves when the spacing of its grid is halved");
  options->study.add_to(*command);
  command->add_flag("--twice", options->twice, "Twice the spacing as well, for the order of convergence");
  command->add_flag("--quarter", options->quarter, "A quarter of the spacing as well; takes long");
  command->add_option("--out", options->out, "JSON file for the figures")->type_name("FILE");
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return converge_scan(*options, context, bar); });
  });
}

}  // namespace vacuform::cli
