#include "worker/forming/temperature_findings.hpp"

#include <algorithm>

#include "api/base/decimal.hpp"
#include "worker/forming/material.hpp"

namespace vacuform {

std::vector<Warning> temperature_findings(const FormedSheet& sheet, Material material) {
  const MaterialProfile profile = material_profile(material);
  std::string plastic(name(material));
  std::transform(plastic.begin(), plastic.end(), plastic.begin(),
                 [](char c) { return static_cast<char>(c - 'a' + 'A'); });
  std::vector<Warning> warnings;
  const auto look = [&](const char* code, const char* comparative, const char* consequence, auto&& excess) {
    std::vector<int> out;
    double free = 0;
    for (std::size_t v = 0; v < sheet.temperature.size(); ++v) {
      if (sheet.contact[v] == Contact::clamp) continue;
      free += 1;
      if (excess(sheet.temperature[v]) > 0.05) out.push_back(static_cast<int>(v));
    }
    if (out.empty()) return;
    std::stable_sort(out.begin(), out.end(), [&](int a, int b) {
      return excess(sheet.temperature[a]) > excess(sheet.temperature[b]);
    });
    const auto worst = static_cast<std::size_t>(out.front());
    const Eigen::Vector3d& p = sheet.formed[worst];
    const double share = 100 * static_cast<double>(out.size()) / free;
    Warning warning{
        code, "The sheet is up to " + decimal(std::max(1.0, excess(sheet.temperature[worst])), 0) +
                  " degrees " + comparative + " than " + plastic + " forms (" +
                  decimal(profile.coldest_celsius, 0) + " to " + decimal(profile.hottest_celsius, 0) +
                  " C): " + decimal(sheet.temperature[worst], 0) + " C at x = " + decimal(p.x(), 0) +
                  " mm, y = " + decimal(p.y(), 0) + " mm, z = " + decimal(p.z(), 0) + " mm, outside over " +
                  (share < 1 ? std::string("less than 1") : decimal(share, 0)) + " % of it; " + consequence};
    warning.figure =
        Warning::Figure{sheet.temperature[worst], "C",
                        sheet.temperature[worst] < profile.coldest_celsius ? profile.coldest_celsius
                                                                           : profile.hottest_celsius};
    constexpr double apart_mm = 40;
    for (const int v : out) {
      const Eigen::Vector3d& q = sheet.formed[v];
      const bool near = std::any_of(warning.marks.begin(), warning.marks.end(), [&](const Warning::Mark& m) {
        return (Eigen::Vector3d(m.place_mm[0], m.place_mm[1], m.place_mm[2]) - q).norm() < apart_mm;
      });
      if (!near) warning.marks.push_back({{q.x(), q.y(), q.z()}});
      if (warning.marks.size() == Warning::most_marks) break;
    }
    warnings.push_back(std::move(warning));
  };
  look("too-cold", "colder", "it tears there or does not follow the mold",
       [&](double celsius) { return profile.coldest_celsius - celsius; });
  look("too-hot", "hotter", "it sags, blisters or thins there",
       [&](double celsius) { return celsius - profile.hottest_celsius; });
  return warnings;
}

}  // namespace vacuform
