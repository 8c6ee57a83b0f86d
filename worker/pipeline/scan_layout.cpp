#include "worker/pipeline/scan_layout.hpp"

#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "api/base/sha256.hpp"
#include "api/job_inputs.hpp"
#include "api/version.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/pipeline/artifact_files.hpp"
#include "worker/pipeline/formed_head.hpp"
#include "worker/stage/warning_json.hpp"

namespace vacuform {

namespace {

using LayoutJson = nlohmann::ordered_json;

LayoutJson pair_json(const std::optional<StrongestPair>& pair, const Array& array) {
  if (!pair) return nullptr;
  const auto id = [&](int i) { return array.drawing.elements[i].id; };
  return {{"a", id(pair->a)}, {"b", id(pair->b)}, {"k", rounded(pair->k)}};
}

LayoutJson layout_json(const Inputs& inputs, const Array& array) {
  return {{"vacuform", version},
          {"sha256", {{"scan", sha256_hex(inputs.scan.bytes)}}},
          {"settings", to_json(inputs.settings)},
          {"count", array.drawing.elements.size()},
          {"diameter_mm", rounded(array.diameter_mm, 2)},
          {"spacing_mm", rounded(array.spacing_mm, 2)},
          {"spacing_rms_mm", rounded(array.spacing_rms_mm, 3)},
          {"pairs", array.pairs},
          {"off_head", array.off_head},
          {"covered", rounded(array.covered, 3)},
          {"k_rms", rounded(array.k_rms, 5)},
          {"strongest_neighbours", pair_json(array.strongest_neighbours, array)},
          {"strongest", pair_json(array.strongest, array)},
          {"warnings", LayoutJson::array()}};
}

Warning coils_off_head(const Array& array) {
  Warning warning{"coil-off-head", std::to_string(array.off_head) + " of " +
                                       std::to_string(array.drawing.elements.size()) +
                                       " coils do not lie wholly on the formed part"};
  warning.figure = Warning::Figure{static_cast<double>(array.off_head), "", 0};
  warning.fix = "Set a smaller layout.diameter_mm or layout.count, or lower scan.trim_mm.";
  return warning;
}

}  // namespace

Result<ScanLayout> lay_out_scan(const Inputs& inputs, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_CHECK(check_for(JobKind::layout, s));
  VACUFORM_CHECK(check_inputs(
      JobKind::layout, [&](std::string_view name) { return has_input(inputs, name); }, s));
  VACUFORM_TRY(formed, form_head(inputs, context));
  const InkedSurface surface = inked_surface(formed.sheet, s.pattern.inked_face);
  VACUFORM_TRY(flattening, flatten(formed.sheet, surface, formed.mold, s.flattening, context));
  VACUFORM_TRY(array, lay_out_array(ChartedSurface(surface, flattening), s.layout, s.coils, context));
  LayoutJson report = layout_json(inputs, array);
  std::vector<Warning> of_array;
  if (array.off_head > 0) of_array.push_back(coils_off_head(array));
  if (array.coupled) of_array.push_back(*array.coupled);
  const auto add = [&](Stage stage, const std::vector<Warning>& warnings) {
    for (const Warning& warning : warnings) report["warnings"].push_back(warning_json(stage, warning));
  };
  add(Stage::scan, formed.mold.warnings);
  add(Stage::forming, formed.sheet.warnings);
  add(Stage::flattening, flattening.warnings);
  add(Stage::printing, of_array);
  return ScanLayout{std::move(array), std::move(report)};
}

std::string title_of(const Array& array) {
  return std::to_string(array.drawing.elements.size()) + " coils, " + decimal(array.diameter_mm, 1) +
         " mm, centres " + decimal(array.spacing_mm, 2) + " mm apart";
}

Result<void> write_layout(const ScanLayout& layout, const std::filesystem::path& out) {
  const std::string svg = svg_of_rings(layout.array.drawing, title_of(layout.array)),
                    json = layout.report.dump(2, ' ', false, LayoutJson::error_handler_t::replace) + "\n";
  return write_artifacts(
      out, {{"pattern.svg", {svg.begin(), svg.end()}}, {"layout.json", {json.begin(), json.end()}}});
}

}  // namespace vacuform
