// The unit and the size of a scan, and what is proposed when they are not clear.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/scan_size.hpp"
#include "worker/scan/trimming.hpp"

namespace vacuform::scan_size_test {
namespace {

using namespace shapes;
using Words = std::vector<std::string>;

const Context quiet;

Result<Mold> mold_of(double longest, const ScanSettings& settings = {}) {
  return make_mold(stl(scaled(sphere(0.5), longest)), "scan.stl", settings, quiet);
}

// As a client applies it: its groups are merged into the settings.
ScanSettings with(const ScanSettings& scan, const Proposal& proposal) {
  Settings settings;
  settings.scan = scan;
  auto json = nlohmann::json(to_json(settings));
  json.merge_patch(nlohmann::json(proposals_json(std::vector{proposal})[0]["set"]));
  const auto merged = settings_from_json(json);
  EXPECT_TRUE(merged) << merged.error().text();
  return merged->scan;
}

Words words_of(const std::vector<Proposal>& proposals) {
  Words words;
  for (const Proposal& proposal : proposals) words.push_back(proposal.set.front().word);
  return words;
}

const Warning* warning_of(const Mold& mold, const std::string& code) {
  for (const Warning& warning : mold.warnings)
    if (warning.code == code) return &warning;
  return nullptr;
}

struct Size {
  double longest;
  Unit unit;
};
class GuessedUnit : public testing::TestWithParam<Size> {};

TEST_P(GuessedUnit, IsTheOnlyPlausibleOne) {
  const auto mold = mold_of(GetParam().longest);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_EQ(mold->findings.unit, GetParam().unit);
  EXPECT_TRUE(mold->findings.unit_guessed);
  EXPECT_NEAR(mold->findings.size_mm.z(), GetParam().longest * millimetres(GetParam().unit), 0.02);
}
INSTANTIATE_TEST_SUITE_P(All, GuessedUnit,
                         testing::Values(Size{200, Unit::mm}, Size{85, Unit::mm}, Size{390, Unit::mm},
                                         Size{20, Unit::cm}, Size{0.2, Unit::m}, Size{0.39, Unit::m},
                                         Size{7.5, Unit::in}, Size{3.2, Unit::in}, Size{115'000, Unit::um},
                                         Size{263'370, Unit::um}));

TEST(Units, TwoPlausibleOnesAreNamedWithTheirSizes) {
  const auto mold = mold_of(10);
  ASSERT_FALSE(mold);
  EXPECT_EQ(mold.error().code, Code::ambiguous_units);
  EXPECT_EQ(mold.error().text(),
            "the scan's unit is not clear: its longest side is plausible in cm (100 mm), in (254 mm) "
            "(scan.stl); set the unit of the file: --set scan.units=cm (100 mm, a newborn's head) or "
            "--set scan.units=in (254 mm, a child's or an adult's head); or measure the longest side of the "
            "head and give it in mm as scan.size_mm");
  EXPECT_EQ(proposals_json(mold.error().proposals).dump(),
            R"([{"set":{"scan":{"units":"cm"}},"text":"100 mm, a newborn's head"},)"
            R"({"set":{"scan":{"units":"in"}},"text":"254 mm, a child's or an adult's head"}])");
}

// Only sizes of heads, or of figurines above 30 mm, are proposed; the likeliest first.
TEST(Units, OnlyPossibleOnesAreProposed) {
  const std::pair<double, Words> rows[] = {
      {0.065, {"m"}},      // a preterm newborn
      {0.6, {"m", "ft"}},  // head and shoulders, or a child
      {1.0, {}},           // a model scaled to a cube: in feet it would be 305 mm
      {2.0, {}},           // the same from -1 to 1
      {2.677, {"in"}},     // a preterm newborn
      {57, {"cm", "mm"}},  // head and shoulders, or a figurine: an adult at a scale of 0.3
      {450, {"mm"}},       // head and shoulders
      {5000, {}},          // 5 m
      {65'000, {"um"}},    // a preterm newborn
      {1e6, {}},          {1e-5, {}}};
  for (const auto& [side, units] : rows) {
    const auto refused = mold_of(side);
    ASSERT_FALSE(refused) << side;
    EXPECT_EQ(refused.error().code, Code::ambiguous_units);
    EXPECT_EQ(words_of(refused.error().proposals), units) << side << ": " << refused.error().text();
    // A size is asked for and never proposed.
    EXPECT_NE(refused.error().fix.find("give it in mm as scan.size_mm"), std::string::npos) << side;
    EXPECT_EQ(refused.error().fix.find("scan.size_mm="), std::string::npos) << side;
  }
}

TEST(Units, EachProposalOfARefusalWorks) {
  for (const double side :
       {1e-5, 1e-3, 0.013, 0.065, 0.6, 1.0, 5.0, 10.0, 34.5, 57.0, 60.0, 450.0, 5000.0, 65e3, 1e6})
    for (const Unit given : {Unit::automatic, Unit::um, Unit::mm, Unit::m, Unit::ft}) {
      ScanSettings settings;
      settings.units = given;
      const auto refused = mold_of(side, settings);
      if (refused) continue;
      for (const Proposal& proposal : refused.error().proposals) {
        EXPECT_NE(refused.error().fix.find(options_of(proposal)), std::string::npos) << refused.error().fix;
        const auto mold = mold_of(side, with(settings, proposal));
        EXPECT_TRUE(mold) << side << ": " << options_of(proposal) << ": " << mold.error().text();
      }
    }
}

TEST(Units, AnotherPossibleOneIsWarnedOf) {
  const auto doubted = mold_of(19.7);  // 197 mm, or half a metre
  ASSERT_TRUE(doubted) << doubted.error().text();
  const Warning* warning = warning_of(*doubted, "units-guessed");
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->text,
            "The unit was taken to be cm, in which the longest side is 197 mm; it could be in (500 mm)");
  EXPECT_EQ(warning->what_to_do(),
            "Set scan.units if the size is wrong: --set scan.units=in (500 mm, a head with shoulders).");
  const std::pair<double, Words> rows[] = {
      {200, {}},      {0.2, {}},       {115, {}},
      {0.263, {}},    {0.377, {"ft"}},  // a newborn in feet, or 377 mm in metres
      {0.3, {"ft"}},                    // the same with 300 mm
      {34.5, {"mm"}},                   // a newborn at a scale of 0.3, or 345 mm in centimetres
      {4.53, {"cm"}},                   // a newborn in inches, or a figurine in centimetres
      {115'000, {}}};
  for (const auto& [side, units] : rows) {
    const auto mold = mold_of(side);
    ASSERT_TRUE(mold) << side << ": " << mold.error().text();
    const Warning* doubt = warning_of(*mold, "units-guessed");
    EXPECT_EQ(doubt ? words_of(doubt->proposals) : Words(), units) << side;
    EXPECT_EQ(doubt != nullptr, !units.empty() || side == 115'000) << side;  // micrometres are rare
    if (units.empty()) continue;
    const auto other = mold_of(side, with({}, doubt->proposals.front()));
    ASSERT_TRUE(other) << side << ": " << other.error().text();
    EXPECT_FALSE(other->findings.unit_guessed);
    EXPECT_FALSE(warning_of(*other, "units-guessed"));
  }
}

TEST(Units, NoPlausibleOneNamesAll) {
  for (const double side : {1.0, 60.0, 450.0, 1e-4, 1e6}) {
    const auto mold = mold_of(side);
    ASSERT_FALSE(mold) << side;
    EXPECT_EQ(mold.error().code, Code::ambiguous_units);
    EXPECT_NE(mold.error().what.find("in none is its longest side 80 to 400 mm: mm ("), std::string::npos)
        << mold.error().text();
  }
}

TEST(Units, AGivenUnitWinsUnlessItIsAbsurd) {
  ScanSettings settings;
  settings.units = Unit::in;
  const auto mold = mold_of(10, settings);
  ASSERT_TRUE(mold) << mold.error().text();
  EXPECT_FALSE(mold->findings.unit_guessed);
  EXPECT_NEAR(mold->findings.size_mm.z(), 254, 0.01);
  settings.units = Unit::m;
  const auto absurd = mold_of(200, settings);
  ASSERT_FALSE(absurd);
  EXPECT_EQ(absurd.error().code, Code::unusable_scan);
  EXPECT_NE(absurd.error().text().find("in m the scan's longest side is 200000.0 mm"), std::string::npos)
      << absurd.error().text();
  EXPECT_EQ(words_of(absurd.error().proposals), Words{"mm"});
}

TEST(Sizes, ASizeThatNoHeadHasIsWarnedOf) {
  ScanSettings settings;
  settings.units = Unit::cm;
  const auto small = mold_of(3, settings);
  ASSERT_TRUE(small) << small.error().text();
  const Warning* warning = warning_of(*small, "size-unusual");
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->text,
            "In cm the longest side is 30 mm: a figurine, not a head, which measures 60 mm to 700 mm");
  EXPECT_DOUBLE_EQ(warning->figure->value, 30);
  EXPECT_EQ(warning->figure->limit, 60);
  EXPECT_EQ(words_of(warning->proposals), Words{"in"});

  ScanSettings sized;
  sized.size_mm = 20;  // centimetres where millimetres are asked for
  const auto typed = mold_of(1, sized);
  ASSERT_TRUE(typed) << typed.error().text();
  ASSERT_TRUE(warning_of(*typed, "size-unusual"));
  EXPECT_TRUE(warning_of(*typed, "size-unusual")->proposals.empty());
  sized.size_mm = 900;
  EXPECT_EQ(warning_of(*mold_of(1, sized), "size-unusual")->figure->limit, 700);

  for (const double side : {61.0, 115.0, 200.0, 690.0}) {
    ScanSettings given;
    given.units = Unit::mm;
    EXPECT_FALSE(warning_of(*mold_of(side, given), "size-unusual")) << side;
    sized.size_mm = side;
    EXPECT_FALSE(warning_of(*mold_of(1, sized), "size-unusual")) << side;
  }
}

TEST(Sizes, AreNamedByKind) {
  EXPECT_EQ(kinds_of_size(5), "smaller than a figurine");
  EXPECT_EQ(kinds_of_size(40), "a figurine");
  EXPECT_EQ(kinds_of_size(89), "a newborn's head");
  EXPECT_EQ(kinds_of_size(126), "a newborn's or a child's head");
  EXPECT_EQ(kinds_of_size(207), "a child's or an adult's head");
  EXPECT_EQ(kinds_of_size(300), "an adult's head, or a head with shoulders");
  EXPECT_EQ(kinds_of_size(690), "a head with shoulders");
  EXPECT_EQ(kinds_of_size(701), "larger than head and shoulders");
}

// A trim is proposed only where the part above it is a mold.
TEST(Trim, ProposalsAreTried) {
  const auto body = shifted(scaled(sphere(0.5), 100), 0, 0, 50);
  ScanSettings settings;
  settings.trim_mm = 200;
  const auto trims_for = [&](const CanCut& can_cut) {
    const auto refused = choose_trim(body, std::nullopt, settings, {}, Eigen::Matrix3d::Identity(),
                                     "scan.stl", can_cut, ScanProgress(quiet));
    EXPECT_FALSE(refused);
    std::vector<double> trims;
    for (const Proposal& proposal : refused.error().proposals) trims.push_back(*proposal.set.front().number);
    return trims;
  };
  using Trims = std::vector<double>;
  EXPECT_EQ(trims_for([](const auto&, double) { return true; }), Trims{50});
  EXPECT_EQ(trims_for([](const auto&, double height) { return height > 55; }), Trims{60});
  EXPECT_EQ(trims_for([](const auto&, double) { return false; }), Trims{});
}

}  // namespace
}  // namespace vacuform::scan_size_test
