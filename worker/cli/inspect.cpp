// vacuform inspect: what a scan contains and what mold it makes, in seconds and without forming.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "worker/cli/commands.hpp"
#include "worker/cli/input_files.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/settings_options.hpp"
#include "worker/pipeline/scan_inspection.hpp"
#include "worker/scan/findings_json.hpp"
#include "worker/stage/warning_json.hpp"

namespace vacuform::cli {

namespace {

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::string scan, out, cache;
  bool json = false;
  ProgressAs progress = ProgressAs::bar;
  SettingsOptions settings;
};

void line(const char* title, const std::string& text) { std::printf("%-12s %s\n", title, text.c_str()); }

std::string fixed(double value, int places) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", places, value);
  return text;
}
std::string box(const Json& size) {
  return fixed(size[0], 1) + " x " + fixed(size[1], 1) + " x " + fixed(size[2], 1) + " mm";
}
std::string count(int n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

void print_text(const ScanInspection& inspection) {
  const Mold& mold = inspection.mold;
  const auto& f = mold.findings;
  const Json scan = scan_json(f), made = mold_json(mold);
  line("format", f.format + ", " + std::to_string(f.triangles_read) + " triangles");
  line("unit", f.size_given ? "none, scaled to the size given"
                            : std::string(name(f.unit)) + (f.unit_guessed ? " (guessed)" : " (given)"));
  line("up", std::string(name(f.up)) + (f.up_guessed ? " (guessed)" : " (given)"));
  const std::string space = "SPACE=" + std::string(name(f.space));
  line("front", std::string(name(f.front)) + " of the upright scan" +
                    (f.front_assumed                    ? " (assumed)"
                     : !f.front_from_format             ? " (given)"
                     : f.space == PatientSpace::unknown ? " (+z of the file, as the format defines)"
                                                        : " (" + space + " of the file)"));
  if (f.left_from_file)
    line("left", std::string(name(*f.left_from_file)) + " of the upright scan (" + space + " of the file)");
  if (f.left_side != LeftSide::unknown)
    line("left", std::string(f.left_side == LeftSide::minus_x ? "-x" : "+x") +
                     " of the mold (confirmed by a person)");
  line("size", box(scan["size_mm"]) + " upright");
  std::string pieces = count(f.components, "piece", "pieces");
  if (f.components_dropped > 0)
    pieces += ", " + std::to_string(f.components_dropped) + " dropped (debris or inside)";
  if (f.turned_inside_out) pieces += ", turned inside out";
  if (f.mirrored) pieces += ", mirrored";
  if (f.outliers_dropped > 0) pieces += ", " + count(f.outliers_dropped, "outlier", "outliers") + " dropped";
  if (f.crumbs_dropped > 0)
    pieces += ", " + count(f.crumbs_dropped, "crumb", "crumbs") + " dropped beside the trimmed mold";
  line("pieces", pieces);
  line("openings", count(f.holes_closed, "hole closed, ", "holes closed, ") + std::to_string(f.holes_capped) +
                       " closed down to the platform" + (f.rebuilt ? ", wrapped in a new skin" : ""));
  line("trim", fixed(f.trim_mm, 1) + " mm above the lowest point" +
                   (f.trim_chosen ? " (where undercuts begin)" : " (given)"));
  line("mold", box(made["size_mm"]) + ", " + std::to_string(mold.mesh.triangles.size()) + " triangles");
  if (mold.undercuts.empty()) line("undercuts", "none");
  for (std::size_t i = 0; i < mold.undercuts.size() && i < 20; ++i) {
    const auto& u = mold.undercuts[i];
    line(i == 0 ? "undercuts" : "", fixed(u.depth_mm, 1) + " mm deep, " + fixed(u.area_mm2, 0) +
                                        " mm2, at (" + fixed(u.place.x(), 1) + ", " + fixed(u.place.y(), 1) +
                                        ", " + fixed(u.place.z(), 1) + ")");
  }
  line("fits", inspection.problem ? "no: " + inspection.problem->text() : "yes");
  for (const auto& warning : mold.warnings) {
    const Json w = warning_json(Stage::scan, warning);
    line(w["severity"].get<std::string>().c_str(), w["what"].get<std::string>());
    line("", "Where: " + w["place"].get<std::string>());
    line("", "Fix: " + w["fix"].get<std::string>());
  }
}

Result<void> inspect(const InspectOptions& o, const Context& context, ProgressBar& bar) {
  VACUFORM_TRY(object, o.settings.read());
  VACUFORM_TRY(settings, settings_from_json(object));
  VACUFORM_TRY(scan, read_input(o.scan));
  Inputs inputs{*std::move(scan), settings};
  inputs.cache = stage_cache(o.cache, o.progress);
  VACUFORM_TRY(inspection, inspect_scan(inputs, context));
  if (!o.out.empty()) VACUFORM_CHECK(write_inspection(inputs, inspection, o.out, context));
  bar.clear();
  if (o.json)
    std::printf(
        "%s\n",
        findings_json(inputs, inspection).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  else if (o.progress == ProgressAs::bar)
    print_text(inspection);
  return {};
}

}  // namespace

void add_inspect(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* command =
      app.add_subcommand("inspect", "Say what is in a scan and what mold it makes, without forming anything");
  command
      ->add_option("scan,--scan", options->scan,
                   "STL, OBJ, PLY, OFF, GLB, or a zip with an OBJ or PLY and its images")
      ->required()
      ->type_name("SCAN");
  options->settings.add_to(*command);
  CLI::Option* json = command->add_flag("--json", options->json, "JSON on standard output");
  command
      ->add_option("--out", options->out,
                   "Folder for findings.json, preview-findings.png and mold.stl; made when absent")
      ->type_name("DIR");
  command->add_option("--cache", options->cache, "Folder for the mold, as for vacuform run")
      ->type_name("DIR");
  add_progress_option(*command, options->progress)->excludes(json);
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return inspect(*options, context, bar); },
        options->progress);
  });
}

}  // namespace vacuform::cli
