#include "worker/forming/findings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace vacuform::findings_test {
namespace {

// A flat sheet of 20 x 20 cells of 4 mm, 1 mm thick, all of it on the mold.
FormedSheet sheet_on_mold() {
  FormedSheet sheet;
  for (int j = 0; j <= 20; ++j)
    for (int i = 0; i <= 20; ++i) {
      sheet.rest.emplace_back(4 * i - 40, 4 * j - 40);
      sheet.formed.emplace_back(4 * i - 40, 4 * j - 40, 30);
    }
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 20; ++i) {
      const int a = 21 * j + i, b = a + 1, c = b + 21, d = a + 21;
      sheet.triangles.push_back({a, b, c});
      sheet.triangles.push_back({a, c, d});
    }
  sheet.contact.assign(sheet.rest.size(), Contact::mold);
  for (std::size_t v = 0; v < sheet.rest.size(); ++v)
    if (sheet.rest[v].cwiseAbs().maxCoeff() > 39) sheet.contact[v] = Contact::clamp;
  sheet.contact_time.assign(sheet.rest.size(), 0.5);
  sheet.element_thickness.assign(sheet.triangles.size(), 1.0);
  sheet.element_wrinkled.assign(sheet.triangles.size(), 0);
  return sheet;
}

std::string codes(const FormedSheet& sheet) {
  std::string all;
  for (const Warning& w : forming_findings(sheet, {}, 1.0).warnings) all += w.code + " ";
  return all;
}

TEST(FormingFindings, NothingToSayOfAGoodSheet) { EXPECT_EQ(codes(sheet_on_mold()), ""); }

TEST(FormingFindings, APocketIsSaidWithPlaceAndArea) {
  FormedSheet sheet = sheet_on_mold();
  for (int j : {5, 6})
    for (int i : {15, 16}) sheet.contact[21 * j + i] = Contact::free;
  const auto found = forming_findings(sheet, {}, 1.0).warnings;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "not-reached");
  // The triangles with a free corner: nine cells without two corner triangles, 9 x 16 - 2 x 8 mm2.
  EXPECT_NE(found[0].text.find("over 128 mm2 at x = 23 mm, y = -19 mm, z = 30 mm"), std::string::npos)
      << found[0].text;
  ASSERT_EQ(found[0].marks.size(), 1u);
  // Its middle is (22, -18); the triangle there that comes first has its centre two thirds of a millimetre off.
  EXPECT_NEAR(found[0].marks[0].place_mm[0], 22 + 2.0 / 3, 1e-9);
  EXPECT_NEAR(found[0].marks[0].place_mm[1], -18 - 2.0 / 3, 1e-9);
  EXPECT_NEAR(found[0].marks[0].size_mm, 2 * std::sqrt(128 / std::numbers::pi), 1e-9);
}

TEST(FormingFindings, AStretchBeyondTheLawIsSaid) {
  FormedSheet sheet = sheet_on_mold();
  for (int j = 0; j <= 20; ++j)  // a column of cells is stretched four times
    for (int i = 11; i <= 20; ++i) sheet.formed[21 * j + i].x() += 12;
  FindingLimits limits;
  EXPECT_TRUE(forming_findings(sheet, {}, 1.0, limits).warnings.empty());
  limits.stretch = 3;
  const auto found = forming_findings(sheet, {}, 1.0, limits).warnings;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "unstable-stretch");
  EXPECT_NE(found[0].text.find("up to 4.0 times, over 1280 mm2 at x = 11 mm"), std::string::npos)
      << found[0].text;
  EXPECT_NEAR(found[0].figure->value, 4, 1e-9);
  EXPECT_FALSE(torn_at(sheet));
}

TEST(FormingFindings, ASecondTryInHalfTheStepsIsSaid) {
  FormedSheet sheet = sheet_on_mold();
  sheet.summary.half_steps = true;
  const auto found = forming_findings(sheet, {}, 1.0).warnings;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "half-steps");
  EXPECT_EQ(found[0].severity(), Severity::note);
}

TEST(FormingFindings, ASheetThatRanAwayIsTorn) {
  FormedSheet sheet = sheet_on_mold();
  sheet.formed[21 * 10 + 5].z() += 100;  // a vertex that its triangles cannot follow
  const auto tear = torn_at(sheet);
  ASSERT_TRUE(tear);
  EXPECT_GT(tear->stretch, 25);
  EXPECT_GT(tear->area_mm2, 500);
  EXPECT_NEAR(tear->place.x(), -20, 4);
  EXPECT_NEAR(tear->place.y(), 0, 4);
}

// The fillet between mold and platform is free too, and no pocket.
TEST(FormingFindings, DoNotCallAGapThatReachesThePlatformAPocket) {
  FormedSheet sheet = sheet_on_mold();
  for (int j : {5, 6})
    for (int i : {15, 16}) sheet.contact[21 * j + i] = Contact::free;
  sheet.contact[21 * 5 + 17] = Contact::platform;
  EXPECT_EQ(codes(sheet), "");
}

TEST(FormingFindings, WebsAndThinPlacesAreSaid) {
  FormedSheet sheet = sheet_on_mold();
  sheet.element_wrinkled[0] = sheet.element_wrinkled[1] = 1;  // 16 mm2: too small to speak of
  EXPECT_EQ(codes(sheet), "");
  for (int k = 100; k < 110; ++k) sheet.element_wrinkled[k] = 1;
  sheet.element_thickness[7] = 0.29;
  const auto found = forming_findings(sheet, {}, 1.0).warnings;
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].code, "webbing");
  EXPECT_NE(found[0].text.find("over 80 mm2"), std::string::npos) << found[0].text;
  EXPECT_EQ(found[1].code, "thin");
  EXPECT_NE(found[1].text.find("0.29 mm, 29 %"), std::string::npos) << found[1].text;
  ASSERT_EQ(found[0].marks.size(), 1u);
  ASSERT_EQ(found[1].marks.size(), 1u);
  // Triangle 7 is the upper left half of the fourth cell.
  EXPECT_NEAR(found[1].marks[0].place_mm[0], 4 * 3 - 40 + 4.0 / 3, 1e-9);
  EXPECT_NEAR(found[1].marks[0].place_mm[1], -40 + 8.0 / 3, 1e-9);
}

// A fold lies upside down. Where the whole of it lies on the mold, the mold has an undercut, which is said elsewhere.
TEST(FormingFindings, ASheetThatHangsOverIsAWeb) {
  FormedSheet sheet = sheet_on_mold();
  for (const int j : {5, 6}) sheet.formed[21 * j + 11].x() = -12;  // the columns beside it stay at 0 and 8
  EXPECT_EQ(codes(sheet), "");
  for (const int j : {5, 6}) sheet.contact[21 * j + 11] = Contact::platform;
  EXPECT_EQ(codes(sheet), "webbing ");
}

TEST(FormingFindings, ThinPlacesAreMarkedThinnestFirstBelowTheLimitThatIsSet) {
  FormedSheet sheet = sheet_on_mold();
  for (int k = 300; k < 310; ++k) sheet.element_thickness[k] = 0.5;
  sheet.element_thickness[7] = 0.4;
  EXPECT_EQ(codes(sheet), "");
  FindingLimits limits;
  limits.thickness_ratio = 0.55;
  const auto found = forming_findings(sheet, {}, 1.0, limits).warnings;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("the thinnest of 2 places below 55 %"), std::string::npos) << found[0].text;
  ASSERT_EQ(found[0].marks.size(), 2u);
  EXPECT_NEAR(found[0].marks[0].size_mm, 2 * std::sqrt(8 / std::numbers::pi), 1e-9);
  EXPECT_NEAR(found[0].marks[1].size_mm, 2 * std::sqrt(80 / std::numbers::pi), 1e-9);
}

// A web around the foot of a mold: its mark lies in it, not in the middle of the mold.
TEST(FormingFindings, ARingIsMarkedOnItself) {
  FormedSheet sheet = sheet_on_mold();
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (int v : sheet.triangles[k]) middle += sheet.rest[v] / 3;
    sheet.element_wrinkled[k] = middle.norm() > 20 && middle.norm() < 30;
  }
  const auto found = forming_findings(sheet, {}, 1.0).warnings;
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].marks.size(), 1u);
  const auto& place = found[0].marks[0].place_mm;
  EXPECT_GT(std::hypot(place[0], place[1]), 20);
  EXPECT_LT(std::hypot(place[0], place[1]), 30);
}

// A page of marks helps nobody; the text still says how many places there are.
TEST(FormingFindings, MarksAreTheWorstTwenty) {
  FormedSheet sheet = sheet_on_mold();
  for (int j = 0; j < 20; j += 3)
    for (int i = 0; i < 20; i += 3)
      sheet.element_wrinkled[2 * (20 * j + i)] = sheet.element_wrinkled[2 * (20 * j + i) + 1] = 1;
  FindingLimits limits;
  limits.web_mm2 = 10;
  const auto found = forming_findings(sheet, {}, 1.0, limits).warnings;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("of 49 places"), std::string::npos) << found[0].text;
  EXPECT_EQ(found[0].marks.size(), 20u);
}

}  // namespace
}  // namespace vacuform::findings_test
