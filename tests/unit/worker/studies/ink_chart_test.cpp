// The curve of the inks from measured patches: a simulated printer with a known curve is found again.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/studies/ink_chart.hpp"

namespace vacuform {
namespace {

// Five coverages of each ink on four steps, and a bare patch on each.
std::vector<InkPatch> chart_of_four_steps() {
  std::vector<InkPatch> out;
  const double ratios[] = {1.15, 1.5, 1.9, 2.4};
  for (int step = 1; step <= 4; ++step)
    for (int k = 0; k < 16; ++k) {
      InkPatch& patch = out.emplace_back();
      patch.step = step;
      patch.ink = k < 15 ? k / 5 : -1;
      patch.coverage = k < 15 ? (k % 5 + 1) / 5.0 : 0;
      patch.area_ratio = ratios[step - 1];
      patch.id = (k < 15 ? std::string(1, "CMY"[k / 5]) + std::to_string(k % 5 + 1) : std::string("W")) +
                 static_cast<char>('a' + step - 1);
    }
  return out;
}

// Dot gain that saturates; each ink has another one.
double truth(int ink, double c) { return (1.0 + 0.15 * ink) * (1 - std::exp(-(2.2 - 0.5 * ink) * c)); }
double shown_on(const InkPatch& patch) {
  return std::min(1.0, truth(patch.ink, patch.coverage) / patch.area_ratio);
}

// CIE L*a*b* for D50 of the linear light of sRGB, the inverse of what the reader does.
Eigen::Vector3d lab_of(const Eigen::Vector3d& linear) {
  Eigen::Matrix3d m;
  m << 3.1338561, -1.6168667, -0.4906146, -0.9787684, 1.9161415, 0.0334540, 0.0719453, -0.2289914, 1.4052427;
  const Eigen::Vector3d xyz = m.inverse() * linear;
  const auto f = [](double t) {
    return t > std::pow(6.0 / 29, 3) ? std::cbrt(t) : t / (3 * std::pow(6.0 / 29, 2)) + 4.0 / 29;
  };
  const double x = f(xyz[0] / 0.96422), y = f(xyz[1]), z = f(xyz[2] / 0.82521);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

std::span<const std::uint8_t> bytes_in(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// A colorimeter with this noise in L*, a*, b*, on plastic that is not quite white.
std::string measured_lab(const std::vector<InkPatch>& patches, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0, 1);
  const Eigen::Vector3d plastic(0.86, 0.84, 0.78);
  std::string csv = "patch;L;a;b\n";
  for (const InkPatch& patch : patches) {
    Eigen::Vector3d linear = plastic;
    if (patch.ink >= 0) linear[patch.ink] *= 1 - shown_on(patch);
    csv += patch.id;
    for (const double v : lab_of(linear)) csv.append(";").append(std::to_string(v + noise * error(random)));
    csv += "\n";
  }
  return csv;
}

double largest_error(const InkFit& fit) {
  double most = 0;
  for (const auto& row : fit.curve)
    for (int k = 0; k < 3; ++k)
      most = std::max(most, std::abs(row[static_cast<std::size_t>(k) + 1] - truth(k, row[0])));
  return most;
}

TEST(InkFit, FindsTheCurveOfAPrinterWithoutNoise) {
  const auto patches = chart_of_four_steps();
  const auto measured = read_measured_patches(bytes_in(measured_lab(patches, 0, 1)), "m.csv", patches);
  ASSERT_TRUE(measured) << measured.error().text();
  const auto fit = fit_ink_curve(patches, *measured, "m.csv");
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_LT(largest_error(*fit), 0.001);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(fit->count[k], 20);
    EXPECT_LT(fit->rms[k], 0.001);
    EXPECT_GT(fit->rms_linear[k], 0.03);
  }
  ASSERT_EQ(fit->by_step.size(), 4u);
  EXPECT_NEAR(fit->by_step[2][0], 1.9, 1e-9);
}

TEST(InkFit, FindsItWithinFiveHundredthsFromAColorimeterWithNoise) {
  const auto patches = chart_of_four_steps();
  double worst = 0, mean = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto measured = read_measured_patches(bytes_in(measured_lab(patches, 0.5, seed)), "m.csv", patches);
    ASSERT_TRUE(measured) << measured.error().text();
    const auto fit = fit_ink_curve(patches, *measured, "m.csv");
    ASSERT_TRUE(fit) << fit.error().text();
    worst = std::max(worst, largest_error(*fit));
    mean += fit->rms[0] / 20;
    // What is printed is a setting.
    const auto settings = settings_from_json(nlohmann::json{{"print", {{"ink_curve", fit->curve}}}});
    EXPECT_TRUE(settings) << settings.error().text();
  }
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(mean, 0.002);  // the noise is there, and the residual shows it
  RecordProperty("worst_thousandths", static_cast<int>(1000 * worst));
}

TEST(InkFit, FindsInkBeyondFullCoverageWhereItIsStretched) {
  auto patches = chart_of_four_steps();
  std::string csv = "patch,coverage\n";  // twice the ink: it covers the first steps fully
  for (const InkPatch& patch : patches)
    if (patch.ink == 2)
      csv += patch.id + "," + std::to_string(std::min(1.0, 2 * patch.coverage / patch.area_ratio)) + "\n";
  const auto measured = read_measured_patches(bytes_in(csv), "m.csv", patches);
  ASSERT_TRUE(measured) << measured.error().text();
  const auto fit = fit_ink_curve(patches, *measured, "m.csv");
  ASSERT_TRUE(fit) << fit.error().text();
  for (const auto& row : fit->curve) {
    EXPECT_NEAR(row[3], 2 * row[0], 0.002);
    EXPECT_NEAR(row[1], row[0], 1e-9) << "an ink that is not measured stays linear";
  }
  EXPECT_NE(text_of(*fit).find("cyan: not measured"), std::string::npos);
}

TEST(InkFit, NeverFalls) {
  const auto patches = chart_of_four_steps();
  std::string csv = "patch,coverage\n";
  for (const InkPatch& patch : patches)
    if (patch.ink == 0)
      csv +=
          patch.id + "," +
          std::to_string((patch.coverage == 0.6 ? 0.5 : std::min(patch.coverage, 0.55)) / patch.area_ratio) +
          "\n";
  const auto measured = read_measured_patches(bytes_in(csv), "m.csv", patches);
  ASSERT_TRUE(measured) << measured.error().text();
  const auto fit = fit_ink_curve(patches, *measured, "m.csv");
  ASSERT_TRUE(fit) << fit.error().text();
  for (std::size_t i = 1; i < fit->curve.size(); ++i) EXPECT_GE(fit->curve[i][1], fit->curve[i - 1][1]);
}

struct RefusedTable {
  const char* csv;
  const char* says;
  const char* where;
};
class BadPatches : public testing::TestWithParam<RefusedTable> {};

TEST_P(BadPatches, AreRefusedWithTheirLine) {
  const auto patches = chart_of_four_steps();
  const auto measured = read_measured_patches(bytes_in(GetParam().csv), "m.csv", patches);
  const auto fit =
      measured ? fit_ink_curve(patches, *measured, "m.csv") : tl::make_unexpected(measured.error());
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().code, Code::corrupt_file);
  EXPECT_EQ(fit.error().where, GetParam().where);
  EXPECT_NE(fit.error().text().find(GetParam().says), std::string::npos) << fit.error().text();
}

INSTANTIATE_TEST_SUITE_P(
    All, BadPatches,
    testing::Values(RefusedTable{"", "no patch is measured", "m.csv"},
                    RefusedTable{"patch,L,a,b\nC1a,,,\n", "no patch is measured", "m.csv"},
                    RefusedTable{"id,L,a,b\n", "lacks the column patch", "m.csv, line 1"},
                    RefusedTable{"patch,L,a\n", "lacks the column patch", "m.csv, line 1"},
                    RefusedTable{"patch,L,a,b\nC9a,50,0,0\n", "no patch \"C9a\"", "m.csv, line 2"},
                    RefusedTable{"patch,L,a,b\nC1a,50,0,0\nC1a,50,0,0\n", "twice", "m.csv, line 3"},
                    RefusedTable{"patch,L,a,b\nC1a,50,x,0\n", "not a number", "m.csv, line 2"},
                    RefusedTable{"patch,L,a,b\nC1a,50,0\n", "not a number", "m.csv, line 2"},
                    RefusedTable{"patch,L,a,b\nC1a,500,0,0\n", "L is 500", "m.csv, line 2"},
                    RefusedTable{"patch,L,a,b\nC1a,50,0,151\n", "a or b", "m.csv, line 2"},
                    RefusedTable{"patch,R,G,B\nC1a,50,0,256\n", "0 to 255", "m.csv, line 2"},
                    RefusedTable{"patch,coverage\nC1a,55\n", "coverage is 55", "m.csv, line 2"},
                    RefusedTable{"patch,L,a,b\nC1a,50,0,0\n", "no bare patch", "m.csv"},
                    RefusedTable{"patch,L,a,b\nWa,5,0,0\nC1a,50,0,0\n", "too dark", "m.csv"},
                    RefusedTable{"patch,L,a,b\nWa,60,0,0\nC1a,90,0,0\n", "brighter than bare",
                                 "m.csv, line 3"},
                    RefusedTable{"patch,coverage\nC5a,0.9\nC1a,0.2\n", "three coverages of cyan", "m.csv"},
                    RefusedTable{"patch,coverage\nC1a,0.2\nC2a,0.3\nC3a,0.5\n", "the full one", "m.csv"},
                    RefusedTable{"patch,coverage\nC1a,0\nC3a,0\nC5a,0.01\n", "hardly darkens", "m.csv"}));

TEST(InkChart, IsReadBackAsItWasWritten) {
  const auto patches = chart_of_four_steps();
  const std::string text = nlohmann::ordered_json{{"patches", patches_json(patches)}}.dump();
  const auto back = read_patches(bytes_in(text), "chart.json");
  ASSERT_TRUE(back) << back.error().text();
  ASSERT_EQ(back->size(), patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_EQ((*back)[i].id, patches[i].id);
    EXPECT_EQ((*back)[i].ink, patches[i].ink);
    EXPECT_EQ((*back)[i].step, patches[i].step);
    EXPECT_NEAR((*back)[i].coverage, patches[i].coverage, 1e-5);
    EXPECT_NEAR((*back)[i].area_ratio, patches[i].area_ratio, 1e-4);
  }
}

TEST(InkChart, RefusesAnythingElse) {
  for (const char* text :
       {"", "{", "[]", R"({"patches": 3})", R"({"patches": [3]})", R"({"patches": [{"id": "a"}]})",
        R"({"patches": [{"id": "a", "ink": "green", "coverage": 1, "area_ratio": 1, "step": 1}]})",
        R"({"patches": [{"id": "a", "ink": "cyan", "coverage": 1, "area_ratio": 0, "step": 1}]})"}) {
    const auto patches = read_patches(bytes_in(text), "chart.json");
    ASSERT_FALSE(patches) << text;
    EXPECT_EQ(patches.error().code, Code::corrupt_file);
    EXPECT_EQ(patches.error().where, "chart.json");
  }
}

TEST(InkChart, FindsTheStretchOfAPatch) {
  Eigen::Matrix2d stretch;
  stretch << 1.5, 0, 0, 1.2;
  const auto x = hand_made::stretched(200, 40, stretch);
  InkPatch patch;
  patch.place = {30, -24, -0.25};
  std::vector<InkPatch> patches{patch};
  ASSERT_TRUE(find_stretch(x.sheet, hand_made::inked(x.sheet), 10, patches));
  EXPECT_NEAR(patches[0].area_ratio, 1.8, 1e-9);
  EXPECT_NEAR(patches[0].gap_mm, 0.25, 1e-9);
  EXPECT_NEAR((patches[0].rest - Eigen::Vector2d(20, -20)).norm(), 0, 1e-9);
  patches[0].place.x() = 500;
  EXPECT_FALSE(find_stretch(x.sheet, hand_made::inked(x.sheet), 10, patches));
}

}  // namespace
}  // namespace vacuform
