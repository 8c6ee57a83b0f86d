#include "worker/pipeline/scan_inspection.hpp"

#include <nlohmann/json.hpp>

#include "api/base/sha256.hpp"
#include "api/problem.hpp"
#include "api/version.hpp"
#include "worker/pipeline/artifact_files.hpp"
#include "worker/scan/findings_json.hpp"
#include "worker/scan/plug.hpp"
#include "worker/scan/sides.hpp"
#include "worker/stage/warning_json.hpp"

namespace vacuform {

using Json = nlohmann::ordered_json;

Json mold_made_from(const Inputs& inputs) {
  Json scan = to_json(inputs.settings)["scan"];
  scan.erase("left_side");
  return {{"scan", sha256_hex(inputs.scan.bytes)},
          {"type", std::filesystem::path(inputs.scan.name).extension().string()},
          {"settings", std::move(scan)},
          {"plug_height_mm", inputs.settings.machine.plug_height_mm}};
}

namespace {

Result<Mold> made_or_cached(const Inputs& inputs, const Context& context) {
  const Json made_from = mold_made_from(inputs);
  if (auto cached = inputs.cache.mold(made_from)) {
    VACUFORM_CHECK(context.step(Stage::scan, 1));
    return *std::move(cached);
  }
  VACUFORM_TRY(cut, make_mold(inputs.scan.bytes, inputs.scan.name, inputs.settings.scan, context));
  VACUFORM_TRY(mold, on_plug(std::move(cut), inputs.settings.machine.plug_height_mm));
  inputs.cache.store(made_from, mold);
  return mold;
}

}  // namespace

Result<Mold> mold_of(const Inputs& inputs, const Context& context) {
  VACUFORM_TRY(mold, made_or_cached(inputs, context));
  mold.findings.left_side = inputs.settings.scan.left_side;
  if (inputs.settings.pattern.source != PatternSource::scan)
    for (Warning& warning : side_warnings(mold.findings)) mold.warnings.push_back(std::move(warning));
  return mold;
}

namespace {

ScanInspection with_fit(Mold mold, const Settings& s) {
  const auto fit = check_fit(mold, s.sheet, s.machine);
  if (!fit) return ScanInspection{std::move(mold), fit.error()};
  for (Warning& w : fit_findings(mold, s.sheet, s.machine, s.forming.thin_limit))
    mold.warnings.push_back(std::move(w));
  return ScanInspection{std::move(mold), std::nullopt};
}

}  // namespace

Result<ScanInspection> inspect_scan(const Inputs& inputs, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_CHECK(check_for(JobKind::inspection, s));
  VACUFORM_TRY(mold, mold_of(inputs, context));
  return with_fit(std::move(mold), s);
}

Json findings_json(const Inputs& inputs, const ScanInspection& inspection) {
  Json all{{"vacuform", version},
           {"sha256", {{"scan", sha256_hex(inputs.scan.bytes)}}},
           {"scan", scan_json(inspection.mold.findings)},
           {"mold", mold_json(inspection.mold)},
           {"fits", !inspection.problem || inspection.problem->code != Code::does_not_fit},
           {"problem", nullptr},
           {"warnings", Json::array()}};
  if (const auto& problem = inspection.problem)
    all["problem"] = {{"code", meaning(problem->code).slug},
                      {"what", problem->what},
                      {"where", problem->where},
                      {"fix", problem->fix},
                      {"proposals", proposals_json(problem->proposals)},
                      {"place_mm", problem->place_mm ? Json(*problem->place_mm) : Json(nullptr)}};
  for (const Warning& warning : inspection.mold.warnings)
    all["warnings"].push_back(warning_json(Stage::scan, warning));
  return all;
}

Result<void> write_inspection(const Inputs& inputs, const ScanInspection& inspection,
                              const std::filesystem::path& out, const Context& context) {
  VACUFORM_TRY(files, inspection_artifacts(inspection.mold, context));
  const std::string text =
      findings_json(inputs, inspection).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  files.push_back({"findings.json", {text.begin(), text.end()}});
  return write_artifacts(out, files);
}

Result<void> inspect_failure(const Inputs& inputs, const Error& error, const std::filesystem::path& out,
                             const Context& context) {
  VACUFORM_TRY(mold, mold_of(inputs, context));
  ScanInspection inspection = with_fit(std::move(mold), inputs.settings);
  inspection.problem = error;
  return write_inspection(inputs, inspection, out, context);
}

}  // namespace vacuform
