// Settings, measured temperatures, measured patches of inks, and colour profiles.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/settings.hpp"
#include "tests/fuzz/targets.hpp"
#include "worker/forming/heat/measured_field.hpp"
#include "worker/printing/output_profile.hpp"
#include "worker/studies/ink_chart.hpp"

namespace vacuform::fuzz {

void read_settings(Bytes bytes) {
  const auto settings = settings_from_text(text(bytes));
  if (!settings) return require(settings.error().code == Code::bad_settings, "bad settings are called so");
  const std::string written = to_json(*settings).dump();
  const auto again = settings_from_text(written);
  require(again.has_value(), "settings that were written can be read");
  require(to_json(*again).dump() == written, "settings survive being written and read");
}

void read_temperature(Bytes bytes) {
  SheetSettings sheet;
  HeatSettings heat;
  heat.source = HeatSource::measured;
  heat.black_c = 20;
  heat.white_c = 200;
  const auto field = read_measured_field({{bytes.begin(), bytes.end()}, "fuzz.csv"}, sheet, heat);
  if (!field) return require(field.error().code != Code::internal, "a bad table is no fault of Vacuform's");
  for (const double s : {-1.0, -0.5, 0.0, 0.31, 1.0})
    require(std::isfinite(field->at({s * sheet.width_mm, -s * sheet.height_mm})), "temperatures are finite");
}

// The bytes as a chart, and as the measurements of a small one.
void read_ink_chart(Bytes bytes) {
  if (const auto chart = read_patches(bytes, "fuzz.json"))
    for (const InkPatch& patch : *chart)
      require(patch.area_ratio > 0 && patch.coverage >= 0 && patch.coverage <= 1,
              "a chart that is read is usable");
  std::vector<InkPatch> patches;
  for (int step = 1; step <= 2; ++step)
    for (int k = 0; k < 10; ++k) {
      InkPatch& patch = patches.emplace_back();
      patch.ink = k < 9 ? k / 3 : -1;
      patch.coverage = k < 9 ? (k % 3 + 1) / 3.0 : 0;
      patch.step = step;
      patch.area_ratio = step;
      patch.id = std::string(1, "CMYW"[k / 3]) + std::to_string(k % 3) + static_cast<char>('a' + step - 1);
    }
  const auto measured = read_measured_patches(bytes, "fuzz.csv", patches);
  if (!measured) return require(measured.error().code == Code::corrupt_file, "a bad table is called so");
  const auto fit = fit_ink_curve(patches, *measured, "fuzz.csv");
  if (!fit) return require(fit.error().code == Code::corrupt_file, "a table that fits nothing is called so");
  require(settings_from_json(nlohmann::json{{"print", {{"ink_curve", fit->curve}}}}).has_value(),
          "a curve that was fitted is a setting");
}

void read_icc(Bytes bytes) {
  const auto profile = OutputProfile::read(bytes, "fuzz.icc");
  if (!profile)
    return require(profile.error().code != Code::internal, "a bad profile is no fault of Vacuform's");
  std::array<std::uint8_t, 16> pixels{0, 0, 0, 1, 255, 255, 255, 2, 200, 100, 50, 3, 9, 99, 199, 4};
  profile->convert(pixels);
  for (std::size_t i = 0; i < 4; ++i) require(pixels[4 * i + 3] == i + 1, "opacities stay");
}

}  // namespace vacuform::fuzz
