// The codes of warnings: the table, the sources that use them and the page that lists them agree.
#include "worker/stage/warning.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "worker/stage/warning_json.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

const fs::path source = VACUFORM_SOURCE;

TEST(Warnings, EveryCodeInTheSourcesIsInTheTableAndTheOtherWayRound) {
  // How a warning is made: by name, into a list, or by the functions that the stages have for it.
  const std::regex made(
      R"re((?:Warning(?:\s+\w+)?\{|warnings\.push_back\(\s*\{|\bwarn\(|\babout\(drawing,|\blook\()\s*(?:\.code\s*=\s*)?"([a-z0-9-]+)")re");
  std::set<std::string> used, known;
  for (const auto& file : fs::recursive_directory_iterator(source / "worker")) {
    if (file.path().extension() != ".cpp") continue;
    const std::string text = text_of(file.path());
    for (std::sregex_iterator it(text.begin(), text.end(), made), end; it != end; ++it) used.insert((*it)[1]);
  }
  for (const WarningKind& kind : warning_kinds()) known.emplace(kind.code);
  EXPECT_EQ(used, known);
}

TEST(Warnings, HaveSeverityPlaceFigureAndFixAsJson) {
  Warning warning{"thin", "The sheet thins", {{{1, 2, 3.04}, 5}, {{4, 5, 6}, 2}}};
  warning.figure = Warning::Figure{12.34567, "%", 30.0};
  EXPECT_EQ(
      warning_json(Stage::forming, warning).dump(),
      R"({"stage":"forming","code":"thin","severity":"warning","what":"The sheet thins.",)"
      R"("place":"x = 1.0, y = 2.0, z = 3.0 mm and 1 more place",)"
      R"("figure":{"value":12.346,"unit":"%","limit":30.0},"fix":"Use a thicker sheet or a lower mold.",)"
      R"("proposals":[],"marks":[{"place_mm":[1.0,2.0,3.0],"size_mm":5.0},{"place_mm":[4.0,5.0,6.0],"size_mm":2.0}]})");
}

TEST(Warnings, NameTheirProposalsInTheFix) {
  Warning warning{"units-guessed", "The unit was taken to be cm"};
  warning.proposals = {{{{"scan.units", std::string_view("in")}}, "254 mm"}};
  const auto json = warning_json(Stage::scan, warning);
  EXPECT_EQ(json["fix"], "Set scan.units if the size is wrong: --set scan.units=in (254 mm).");
  EXPECT_EQ(json["proposals"].dump(), R"([{"set":{"scan":{"units":"in"}},"text":"254 mm"}])");
}

TEST(Warnings, SayTheirPlaceInWordsAndTheirOwnFixWhereTheyHaveThem) {
  Warning warning{"coil-off-head", "coil-3 lies off."};
  EXPECT_EQ(warning_json(Stage::printing, warning)["place"], "the drawing");
  EXPECT_EQ(warning_json(Stage::printing, warning)["figure"], nullptr);
  EXPECT_EQ(warning_json(Stage::printing, warning)["severity"], "serious");
  warning.place = "coil-3";
  warning.fix = "Move it.";
  EXPECT_EQ(warning_json(Stage::printing, warning)["place"], "coil-3");
  EXPECT_EQ(warning_json(Stage::printing, warning)["fix"], "Move it.");
}

TEST(WarningsDeathTest, ACodeThatIsNotInTheTableEndsTheProgram) {
  EXPECT_DEATH((void)warning_kind("no-such-code"), "no such kind of warning: no-such-code");
}

}  // namespace
}  // namespace vacuform
