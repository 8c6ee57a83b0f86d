// vacuform calibrate: the machine's figures from a formed test grid that was measured.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/study_options.hpp"
#include "worker/pipeline/inputs.hpp"
#include "worker/scan/text_cursor.hpp"
#include "worker/studies/calibration.hpp"

namespace vacuform::cli {

namespace {

struct CalibrateOptions {
  StudyOptions study;
  std::string measured, out;
  std::vector<std::string> priors;
  bool json = false;
  CalibrationOptions calibration;
};

Result<void> read_priors(const std::vector<std::string>& texts, CalibrationOptions& options) {
  for (const std::string& text : texts) {
    const auto sign = text.find('=');
    double error = 0;
    if (sign == std::string::npos || !parse_number(text.substr(sign + 1), error))
      return fail(Code::bad_settings, "not a standard deviation of a prior: " + text, "--prior",
                  "write for example --prior machine.window_width_mm=1");
    options.prior_errors[text.substr(0, sign)] = error;
  }
  return {};
}

Result<void> calibrate_machine(const CalibrateOptions& o, const Context& context, ProgressBar& bar) {
  CalibrationOptions options = o.calibration;
  VACUFORM_CHECK(read_priors(o.priors, options));
  VACUFORM_TRY(study, o.study.read());
  VACUFORM_TRY(csv, read_file(o.measured, 64u << 20));
  VACUFORM_TRY(points, read_measured_grid(csv, o.measured, study.settings.sheet));
  VACUFORM_TRY(prepared, prepare(study.scan, study.settings, study.temperature, context));
  VACUFORM_TRY(calibration, calibrate(prepared, study.settings, points, options, context));
  bar.clear();
  const auto profile = profile_json(calibration, study.written);
  std::fputs((o.json ? profile.dump(2) + "\n" : text_of(calibration)).c_str(), stdout);
  return write_json(o.out, profile);
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
  command
      ->add_option(
          "--prior", options->priors,
          "Standard deviation of the prior about a setting as given, in mm; of forming.edge_stiffness that "
          "of its logarithm. Without: drape height 10, window 5, edge stiffness 0.3")
      ->type_name("SETTING=SD");
  command->add_flag("--json", options->json, "Print the profile as JSON instead of a table");
  command->add_option("--out", options->out, "Machine profile to write, a file for --settings")
      ->required()
      ->type_name("FILE");
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return calibrate_machine(*options, context, bar); });
  });
}

}  // namespace vacuform::cli
