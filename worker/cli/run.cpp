// vacuform run: the whole pipeline, without a server.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/job_inputs.hpp"
#include "api/job_text.hpp"
#include "api/redaction/redaction.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/input_files.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/model_folder.hpp"
#include "worker/cli/outcome.hpp"
#include "worker/cli/settings_options.hpp"
#include "worker/pipeline/pipeline.hpp"
#include "worker/printing/output_profile.hpp"

namespace vacuform::cli {

namespace {

struct RunOptions {
  std::string scan, pattern, temperature, weights, icc, cache, out, reference;
  ProgressAs progress = ProgressAs::bar;
  bool sensitivity = false;
  OutcomeOptions outcome;
  SettingsOptions settings;
};

Result<void> run(const RunOptions& o, const Context& context) {
  VACUFORM_TRY(object, o.settings.read());
  VACUFORM_TRY(settings, settings_from_json(object));
  VACUFORM_TRY(scan, read_file(o.scan));
  Inputs inputs{{std::move(scan), o.scan}, settings};
  if (settings.pattern.source != PatternSource::file)
    VACUFORM_CHECK(add_files_beside(inputs.scan.bytes, inputs.scan.name));
  VACUFORM_CHECK(redact(inputs.scan.bytes, inputs.scan.name));
  VACUFORM_TRY(pattern, read_input(o.pattern));
  inputs.pattern = std::move(pattern);
  VACUFORM_TRY(temperature, read_input(o.temperature));
  inputs.temperature = std::move(temperature);
  VACUFORM_TRY(weights, read_input(o.weights));
  inputs.weights = std::move(weights);
  VACUFORM_TRY(icc, read_input(o.icc, OutputProfile::largest_bytes));
  inputs.icc = std::move(icc);
  use_inputs([&](std::string_view name) { return has_input(inputs, name); }, inputs.settings);
  VACUFORM_TRY(reference, clean_reference(o.reference));
  inputs.reference = std::move(reference);
  inputs.sensitivity = o.sensitivity;
  inputs.cache = stage_cache(o.cache, o.progress);
  return run_pipeline(inputs, o.out, context);
}

// The table of the report on the terminal.
void print_sensitivity(const nlohmann::ordered_json& report) {
  if (!report.contains("sensitivity")) return;
  std::printf("shift of the coils' centres, mm              mean      max\n");
  for (const auto& change : report["sensitivity"]["changes"]) {
    const auto text = change["text"].get<std::string>();
    if (change["mean_mm"].is_null())
      std::printf("%-42s (not formed)\n", text.c_str());
    else
      std::printf("%-42s %6.2f   %6.2f\n", text.c_str(), change["mean_mm"].get<double>(),
                  change["max_mm"].get<double>());
  }
}

int run_command(const RunOptions& o) {
  const ProgressAs progress = o.outcome.quiet ? ProgressAs::none : o.progress;
  const int exit_code =
      run_interruptible([&](const Context& context, ProgressBar&) { return run(o, context); }, progress);
  if (exit_code != 0) return exit_code;
  const auto report = read_report(std::filesystem::path(o.out) / "report.json");
  if (progress != ProgressAs::json) tell(o.outcome, report, o.out);
  if (o.sensitivity && progress == ProgressAs::bar && !o.outcome.json) print_sensitivity(report);
  return exit_code_of(o.outcome, report);
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Make the print of a scan and a pattern, without a server");
  command
      ->add_option("--scan", options->scan,
                   "STL, OBJ, PLY, OFF, GLB, or a zip with an OBJ or PLY and its images")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--pattern", options->pattern,
                   "SVG, PNG or JPEG; with pattern.source=scan, which prints the colours of the scan, none")
      ->type_name("FILE");
  command->add_option("--out", options->out, "Folder for the artifacts; made when absent")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--temperature", options->temperature,
                   "Measured temperature of the sheet: CSV of degrees Celsius, or a gray PNG")
      ->type_name("FILE");
  command
      ->add_option(
          "--weights", options->weights,
          "Picture over the pattern: where it is dark, the chart is distorted least; PNG, JPEG or SVG")
      ->type_name("FILE");
  command
      ->add_option(
          "--icc", options->icc,
          "RGB ICC profile of the printer: pixels that have colours are converted to it; without, they are "
          "sRGB")
      ->type_name("FILE");
  command
      ->add_option("--cache", options->cache,
                   "Folder for what scan and forming made: another pattern, or the same one moved, then "
                   "prints without "
                   "forming the head again. It holds heads; delete it when they are done")
      ->type_name("DIR");
  command
      ->add_option("--reference", options->reference,
                   std::string(reference_hint) + " The print and the report show it")
      ->type_name("TEXT");
  options->settings.add_to(*command);
  command->add_flag("--sensitivity", options->sensitivity,
                    "Form seven times more, each with one thing changed, and report how far the coils move");
  CLI::Option* progress = add_progress_option(*command, options->progress);
  const auto added = options->outcome.add_to(*command);
  added.json->excludes(progress);
  added.quiet->excludes(progress);
  command->callback([options, &exit_code] { exit_code = run_command(*options); });
}

}  // namespace vacuform::cli
