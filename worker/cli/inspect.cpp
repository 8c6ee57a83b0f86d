// vacuform inspect: what is in a scan and what mold it makes, in seconds and without forming anything.
#include <cstdio>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>

#include "worker/cli/commands.hpp"
#include "worker/cli/progress_bar.hpp"
#include "worker/cli/settings_options.hpp"
#include "worker/pipeline.hpp"
#include "worker/scan/findings_json.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/plug.hpp"

namespace vacuform::cli {

namespace {

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::string scan;
  bool json = false;
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

void print_text(const Mold& mold, const Result<void>& fit) {
  const auto& f = mold.findings;
  const Json scan = scan_json(f), made = mold_json(mold);
  line("format", f.format + ", " + std::to_string(f.triangles_read) + " triangles");
  line("unit", f.size_given ? "none, scaled to the size given"
                            : std::string(name(f.unit)) + (f.unit_guessed ? " (guessed)" : " (given)"));
  line("up", std::string(name(f.up)) + (f.up_guessed ? " (guessed)" : " (given)"));
  line("size", box(scan["size_mm"]) + " upright");
  std::string pieces = count(f.components, "piece", "pieces");
  if (f.components_dropped > 0)
    pieces += ", " + std::to_string(f.components_dropped) + " dropped (debris or inside)";
  if (f.turned_inside_out) pieces += ", turned inside out";
  line("pieces", pieces);
  line("openings", count(f.holes_closed, "hole closed, ", "holes closed, ") + std::to_string(f.holes_capped) +
                       " walled in down to the platform" + (f.rebuilt ? ", the skin wrapped anew" : ""));
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
  line("fits", fit ? "yes" : "no: " + fit.error().text());
  for (const auto& warning : mold.warnings) line("warning", warning.text);
}

void print_json(const Mold& mold, const Result<void>& fit) {
  Json out{{"scan", scan_json(mold.findings)}, {"mold", mold_json(mold)}, {"fits", fit.has_value()}};
  if (!fit)
    out["problem"] = {{"code", meaning(fit.error().code).slug},
                      {"what", fit.error().what},
                      {"where", fit.error().where},
                      {"mend", fit.error().mend}};
  out["warnings"] = Json::array();
  for (const auto& warning : mold.warnings)
    out["warnings"].push_back(
        {{"code", warning.code}, {"text", warning.text}, {"marks", marks_json(warning)}});
  std::printf("%s\n", out.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

Result<void> inspect(const InspectOptions& o) try {
  VACUFORM_TRY(object, o.settings.read());
  VACUFORM_TRY(settings, settings_from_json(object));
  VACUFORM_TRY(bytes, read_file(o.scan));
  ProgressBar bar(ProgressBar::Otherwise::silent);
  auto cut = make_mold(bytes, o.scan, settings.scan,
                       Context([&](Stage stage, double fraction) { bar.show(stage, fraction); }));
  bar.clear();
  if (!cut) return tl::make_unexpected(cut.error());
  VACUFORM_TRY(mold, on_plug(std::move(*cut), settings.machine.plug_height_mm));
  const auto fit = check_fit(mold, settings.sheet, settings.machine);
  if (fit)
    for (Warning& w : fit_findings(mold, settings.sheet, settings.machine, settings.forming.thin_limit))
      mold.warnings.push_back(std::move(w));
  (o.json ? print_json : print_text)(mold, fit);
  return {};
} catch (const std::bad_alloc&) {
  return tl::make_unexpected(out_of_memory());
}

}  // namespace

void add_inspect(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* command =
      app.add_subcommand("inspect", "Say what is in a scan and what mold it makes, without forming anything");
  command->add_option("scan", options->scan, "STL, OBJ, PLY, OFF or GLB")->required()->type_name("SCAN");
  options->settings.add_to(*command);
  command->add_flag("--json", options->json, "JSON on standard output");
  command->callback([options, &exit_code] {
    const auto done = inspect(*options);
    exit_code = done ? 0 : refuse(done.error());
  });
}

}  // namespace vacuform::cli
