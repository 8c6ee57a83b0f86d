// vacuform calibrate: the machine's figures from a formed test grid that was measured.
#include <cmath>
#include <cstdio>
#include <memory>

#include "worker/cli/commands.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/study_options.hpp"
#include "worker/pipeline.hpp"
#include "worker/studies/calibration.hpp"

namespace vacuform::cli {

namespace {

struct CalibrateOptions {
  StudyOptions study;
  std::string measured, out;
  CalibrationOptions calibration;
};

void print(const Calibration& c) {
  for (const FittedParameter& p : c.parameters) {
    std::printf("%-26s %9.3f", (p.group + "." + p.key).c_str(), p.value);
    if (std::isfinite(p.standard_error))
      std::printf(" +- %.3f", p.standard_error);
    else
      std::printf(" (the points do not tell)");
    std::printf("%s\n", p.at_bound ? ", at the end of what was searched" : "");
  }
  const auto line = [](const char* title, const DistanceStatistics& s) {
    std::printf("%-26s mean %.3f, RMS %.3f, 95 %% %.3f, max %.3f mm over %zu points\n", title, s.mean, s.rms,
                s.p95, s.max, s.count);
  };
  line("residual before", c.before);
  line("residual", c.after);
  if (c.outliers > 0) std::printf("%-26s %d\n", "points that hardly count", c.outliers);
}

Result<void> calibrate_machine(const CalibrateOptions& o, const Context& context, ProgressBar& bar) {
  VACUFORM_TRY(study, o.study.read());
  VACUFORM_TRY(csv, read_file(o.measured, 64u << 20));
  VACUFORM_TRY(points, read_measured_grid(csv, o.measured, study.settings.sheet));
  VACUFORM_TRY(prepared, o.study.prepare(study, context));
  VACUFORM_TRY(calibration, calibrate(prepared, study.settings, points, o.calibration, context));
  bar.clear();
  print(calibration);
  return write_json(o.out, profile_json(calibration, study.written));
}

}  // namespace

void add_calibrate(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command =
      app.add_subcommand("calibrate", "Fit the machine to a formed test grid that was measured");
  options->study.add_to(*command);
  command->add_option("--measured", options->measured, "CSV of the formed grid: s, t, x, y, z in mm")
      ->required()
      ->type_name("FILE");
  command->add_flag(
      "--registered", options->calibration.registered,
      "The points are in the machine's frame: z up from the platform, x and y from the sheet's centre");
  command->add_option("--out", options->out, "Machine profile to write, a file for --settings")
      ->required()
      ->type_name("FILE");
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return calibrate_machine(*options, context, bar); });
  });
}

}  // namespace vacuform::cli
