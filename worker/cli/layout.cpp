// vacuform layout: an array of coils made for a scan, as a pattern that a person can edit.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/job_inputs.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/input_files.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/settings_options.hpp"
#include "worker/pipeline/scan_layout.hpp"

namespace vacuform::cli {

namespace {

struct LayoutOptions {
  std::string scan, temperature, cache, out;
  ProgressAs progress = ProgressAs::bar;
  SettingsOptions settings;
};

void print_coupling(const char* of_what, const nlohmann::ordered_json& pair) {
  if (pair.is_null()) return;
  std::printf("strongest coupling of %s: %s and %s, k = %.4f\n", of_what,
              pair["a"].get_ref<const std::string&>().c_str(),
              pair["b"].get_ref<const std::string&>().c_str(), pair["k"].get<double>());
}

void print_text(const ScanLayout& layout) {
  const Array& array = layout.array;
  std::printf("%s on the head, spacing %.2f mm rms over %d pairs, over %.0f %% of the region\n",
              title_of(array).c_str(), array.spacing_rms_mm, array.pairs, 100 * array.covered);
  print_coupling("neighbours", layout.report["strongest_neighbours"]);
  print_coupling("any two coils", layout.report["strongest"]);
  if (array.off_head > 0) std::printf("%d of them do not lie wholly on the formed part\n", array.off_head);
}

Result<void> lay_out(const LayoutOptions& o, const Context& context, ProgressBar& bar) {
  VACUFORM_TRY(object, o.settings.read());
  VACUFORM_TRY(settings, settings_from_json(object));
  VACUFORM_TRY(scan, read_input(o.scan));
  Inputs inputs{*std::move(scan), settings};
  VACUFORM_TRY(temperature, read_input(o.temperature));
  inputs.temperature = std::move(temperature);
  use_inputs([&](std::string_view name) { return has_input(inputs, name); }, inputs.settings);
  inputs.cache = stage_cache(o.cache, o.progress);
  VACUFORM_TRY(layout, lay_out_scan(inputs, context));
  VACUFORM_CHECK(write_layout(layout, o.out));
  bar.clear();
  if (o.progress == ProgressAs::bar) print_text(layout);
  return {};
}

// An option that is a short form of a setting of the group layout.
CLI::Option* add_short_form(CLI::App& command, LayoutOptions& options, const std::string& key,
                            const std::string& text) {
  return command.add_option_function<std::string>(
      "--" + key,
      [&options, key](const std::string& value) {
        options.settings.assignments.push_back("layout." + key + "=" + (value == "fitted" ? "0" : value));
      },
      text);
}

}  // namespace

void add_layout(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<LayoutOptions>();
  CLI::App* command = app.add_subcommand(
      "layout", "Make a pattern of coils for a scan, which a print puts where the layout has them");
  command
      ->add_option("--scan", options->scan,
                   "STL, OBJ, PLY, OFF, GLB, or a zip with an OBJ or PLY and its images")
      ->required()
      ->type_name("FILE");
  options->settings.add_to(*command);
  add_short_form(*command, *options, "count", "Number of coils: layout.count")->check(CLI::Range(4, 64));
  add_short_form(
      *command, *options, "diameter_mm",
      "Of the coils, or fitted: the largest that fit on the region and couple little: layout.diameter_mm")
      ->type_name("D|fitted");
  add_short_form(*command, *options, "region",
                 "The whole dome, or its front (towards +y of the mold; scan.yaw_deg turns the head) or back "
                 "half: layout.region")
      ->check(CLI::IsMember({"dome", "front", "back"}));
  command->add_option("--temperature", options->temperature, "Measured temperature, as for vacuform run")
      ->type_name("FILE");
  command->add_option("--cache", options->cache, "Folder for the mold and the sheet, as for vacuform run")
      ->type_name("DIR");
  command->add_option("--out", options->out, "Folder for pattern.svg and layout.json; made when absent")
      ->required()
      ->type_name("DIR");
  add_progress_option(*command, options->progress);
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return lay_out(*options, context, bar); },
        options->progress);
  });
}

}  // namespace vacuform::cli
