#include "worker/pipeline/formed_head.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "api/base/sha256.hpp"
#include "worker/forming/temperature_findings.hpp"
#include "worker/pipeline/scan_inspection.hpp"
#include "worker/stage/sub_progress.hpp"

namespace vacuform {

namespace {

Result<FormedSheet> sheet_of(const Inputs& inputs, const nlohmann::ordered_json& made_from, const Mold& mold,
                             const TemperatureField& temperature, const Context& context) {
  if (auto cached = inputs.cache.sheet(made_from)) {
    VACUFORM_CHECK(context.step(Stage::forming, 1));
    return *std::move(cached);
  }
  const Settings& s = inputs.settings;
  VACUFORM_TRY(sheet, form(mold, s.sheet, s.machine, s.forming, temperature, context));
  inputs.cache.store(made_from, sheet);
  return sheet;
}

}  // namespace

Result<FormedHead> form_head(const Inputs& inputs, const Context& context) {
  const Settings& s = inputs.settings;
  const nlohmann::ordered_json all = to_json(s);
  VACUFORM_TRY(mold, mold_of(inputs, context));
  VACUFORM_CHECK(check_fit(mold, s.sheet, s.machine));
  VACUFORM_TRY(warmth, sheet_temperature(s.sheet, s.machine, s.heat, inputs.temperature, context));
  const double share = inputs.sensitivity ? 0.15 : 1;  // of the forming stage's work
  const SubProgress nominal(context, {Stage::forming, 0, share}),
      changed(context, {Stage::forming, share, 1});
  const nlohmann::ordered_json of_sheet = {
      {"mold", mold_made_from(inputs)},
      {"settings", {all["sheet"], all["machine"], all["heat"], all["forming"]}},
      {"temperature", inputs.temperature ? sha256_hex(inputs.temperature->bytes) : std::string()}};
  VACUFORM_TRY(sheet, sheet_of(inputs, of_sheet, mold, warmth.field, nominal.context()));
  std::vector<Variant> variants;
  if (inputs.sensitivity) {
    VACUFORM_TRY(formed, form_variants(mold, s, warmth.field, changed.context()));
    variants = std::move(formed);
  }
  const auto of_fit = fit_findings(mold, s.sheet, s.machine, s.forming.thin_limit);
  sheet.warnings.insert(sheet.warnings.begin(), of_fit.begin(), of_fit.end());
  for (Warning& w : warmth.warnings) sheet.warnings.push_back(std::move(w));
  for (Warning& w : temperature_findings(sheet, s.sheet.material)) sheet.warnings.push_back(std::move(w));
  return FormedHead{std::move(mold), std::move(sheet), warmth.summary, std::move(variants)};
}

}  // namespace vacuform
