// The profiles of machines and sheets that come along.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "api/settings.hpp"

namespace vacuform {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Profiles, AreSettingsOfSheetAndMachineThatHoldTogetherOrOfAnInk) {
  const std::filesystem::path folder = VACUFORM_PROFILES;
  const std::string readme = text_of(folder / "README.md");
  int profiles = 0, inks = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".json") continue;
    SCOPED_TRACE(file.path().filename().string());
    ++profiles;
    const std::string text = text_of(file.path());
    const auto settings =
        settings_from_text(text);  // refuses what no schema knows, and a window beyond the sheet
    ASSERT_TRUE(settings) << settings.error().text();
    const auto fragment = nlohmann::json::parse(text);
    std::set<std::string> groups;
    for (const auto& [group, values] : fragment.items()) groups.insert(group);
    std::string name("`");
    name.append(file.path().stem().string()).append("`");
    EXPECT_NE(readme.find(name), std::string::npos) << name << " is not in README.md";
    if (file.path().stem().string().starts_with("ink-")) {
      ++inks;
      EXPECT_EQ(groups, (std::set<std::string>{"circuit"}));
      continue;
    }
    EXPECT_EQ(groups, (std::set<std::string>{"machine", "sheet"}));
    // Window and sheet are what a profile is for: neither is left to the defaults, and the clamp holds the sheet.
    for (const char* key : {"width_mm", "height_mm"}) EXPECT_TRUE(fragment["sheet"].contains(key)) << key;
    for (const char* key : {"window", "window_width_mm", "window_height_mm"})
      EXPECT_TRUE(fragment["machine"].contains(key)) << key;
    EXPECT_GE(settings->sheet.width_mm - settings->machine.window_width_mm, 10);
    EXPECT_GE(settings->sheet.height_mm - settings->machine.window_height_mm, 10);
  }
  EXPECT_GE(profiles, 8);
  EXPECT_EQ(inks, 3);
}

}  // namespace
}  // namespace vacuform
