// vacuform chart: a test sheet for the inks of a printer, and the curve of the inks from its measured patches.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "api/version.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/study_options.hpp"
#include "worker/pipeline/artifact_files.hpp"
#include "worker/pipeline/pipeline.hpp"
#include "worker/sample/stepped_mold.hpp"
#include "worker/studies/ink_chart.hpp"

namespace vacuform::cli {

namespace {

struct ChartOptions {
  SettingsOptions settings;
  std::string out, measured, chart;
  bool json = false;
  ProgressAs progress = ProgressAs::bar;
};

constexpr std::array<std::string_view, 5> kept_files{"print.png", "print.svg", "print.pdf",
                                                     "preview-with.png", "mold.stl"};
constexpr double measured_share = 0.7;  // of a patch's side, where the instrument looks
constexpr double largest_gap_mm = 0.5;  // of a sheet that lies on its step

// The given machine, sheet, forming and print; nothing of other scans and drawings.
Settings settings_of_chart(const Settings& given) {
  Settings s;
  s.sheet = given.sheet;
  s.machine = given.machine;
  s.heat = given.heat;
  s.forming = given.forming;
  s.print = given.print;
  s.pattern.inked_face = given.pattern.inked_face;
  s.pattern.source = PatternSource::scan;
  s.print.compensate_colours = false;
  s.print.ink_curve.clear();
  return s;
}

std::vector<InkPatch> patches_of(const SteppedMold& mold) {
  std::vector<InkPatch> out;
  for (const MoldPatch& p : mold.patches) {
    InkPatch& patch = out.emplace_back();
    patch.id = p.id;
    patch.ink = p.ink;
    patch.coverage = p.coverage;
    patch.step = p.step;
    patch.place = p.place;
  }
  return out;
}

Artifact text_file(const char* name, const std::string& text) { return {name, {text.begin(), text.end()}}; }

Result<std::vector<Artifact>> chart_files(const Finished& job, const SteppedMold& mold,
                                          std::vector<InkPatch>& patches, const Context& context) {
  if (!find_stretch(job.sheet, job.surface, measured_share * mold.patch_mm, patches))
    return fail(Code::forming_failed, "the formed sheet does not cover the patches of the chart", "",
                "use the settings of a machine that forms the sheet, such as those of deploy/profiles");
  VACUFORM_TRY(all, artifacts(job, context));
  std::vector<Artifact> files;
  for (Artifact& file : all)
    if (std::find(kept_files.begin(), kept_files.end(), file.name) != kept_files.end())
      files.push_back(std::move(file));
  const nlohmann::ordered_json json = {{"vacuform", version},
                                       {"label", job.label},
                                       {"patch_mm", mold.patch_mm},
                                       {"measured_share", measured_share},
                                       {"patches", patches_json(patches)},
                                       {"settings", to_json(job.settings)}};
  files.push_back(text_file("chart.json", json.dump(2) + "\n"));
  files.push_back(text_file("measured.csv", table_to_fill(patches)));
  return files;
}

// One line a step: how far it stretches, and whether the sheet lies on it.
void print_steps(const std::vector<InkPatch>& patches) {
  int steps = 0;
  for (const InkPatch& p : patches) steps = std::max(steps, p.step);
  for (int step = 1; step <= steps; ++step) {
    double least = INFINITY, most = 0, gap = 0;
    for (const InkPatch& p : patches)
      if (p.step == step) {
        least = std::min(least, p.area_ratio);
        most = std::max(most, p.area_ratio);
        gap = std::max(gap, p.gap_mm);
      }
    std::printf("step %c: stretched %s to %s times%s\n", 'a' + step - 1, decimal(least, 2).c_str(),
                decimal(most, 2).c_str(),
                gap > largest_gap_mm
                    ? (std::string(", the sheet stays up to ") + in_mm(gap) + " above it").c_str()
                    : "");
  }
}

Result<void> make_chart(const ChartOptions& o, const Context& context, ProgressBar& bar) {
  if (o.out.empty())
    return fail(Code::bad_usage, "there is no folder for the chart", "--out",
                "give --out DIR, or --fit with a measured chart");
  VACUFORM_TRY(object, o.settings.read());
  VACUFORM_TRY(given, settings_from_json(object));
  const Settings settings = settings_of_chart(given);
  const auto mold = stepped_mold(settings.machine);
  if (!mold)
    return fail(Code::bad_settings, "the window of the clamp frame is too small for a test sheet",
                "machine.window_width_mm",
                std::string("use a window of at least ") + in_mm(least_window_mm(settings.machine.window)));
  const Inputs inputs{{mold->glb, "chart.glb"}, settings};
  std::vector<InkPatch> patches = patches_of(*mold);
  VACUFORM_TRY(
      files,
      with_print(
          inputs, [&](const Finished& job) { return chart_files(job, *mold, patches, context); }, context));
  VACUFORM_CHECK(write_artifacts(o.out, files));
  bar.clear();
  if (o.progress == ProgressAs::bar) {
    print_steps(patches);
    std::printf("Files: %s (print.pdf, mold.stl, chart.json; fill in measured.csv)\n", o.out.c_str());
  }
  return {};
}

Result<void> fit_chart(const ChartOptions& o) {
  if (o.chart.empty())
    return fail(Code::bad_usage, "there is no chart to fit", "--chart",
                "give the chart.json that vacuform chart wrote");
  VACUFORM_TRY(json, read_file(o.chart, 16u << 20));
  VACUFORM_TRY(patches, read_patches(json, o.chart));
  VACUFORM_TRY(csv, read_file(o.measured, 16u << 20));
  VACUFORM_TRY(measured, read_measured_patches(csv, o.measured, patches));
  VACUFORM_TRY(fit, fit_ink_curve(patches, measured, o.measured));
  const auto found = fit_json(fit);
  std::fputs((o.json ? found.dump(2) + "\n" : text_of(fit)).c_str(), stdout);
  return o.out.empty() ? Result<void>() : write_json(o.out, found);
}

}  // namespace

void add_chart(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ChartOptions>();
  CLI::App* command = app.add_subcommand(
      "chart", "Make a test sheet for the inks of a printer, or fit print.ink_curve to its measured patches");
  options->settings.add_to(*command);
  command
      ->add_option(
          "--out", options->out,
          "Folder for the print, mold.stl, chart.json and measured.csv; made when absent. With --fit: "
          "file for --settings to write")
      ->type_name("DIR|FILE");
  CLI::Option* fit = command
                         ->add_option("--fit", options->measured,
                                      "CSV of the formed patches: patch, and L, a, b or R, G, B or coverage")
                         ->type_name("FILE");
  command->add_option("--chart", options->chart, "With --fit: chart.json of the measured sheet")
      ->type_name("FILE")
      ->needs(fit);
  command->add_flag("--json", options->json, "With --fit: print the curve as JSON instead of text")
      ->needs(fit);
  add_progress_option(*command, options->progress);
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) {
          return options->measured.empty() ? make_chart(*options, context, bar) : fit_chart(*options);
        },
        options->progress);
  });
}

}  // namespace vacuform::cli
