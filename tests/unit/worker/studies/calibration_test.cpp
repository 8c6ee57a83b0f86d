#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/studies/bayesian_fit.hpp"
#include "worker/studies/calibration.hpp"
#include "worker/studies/inked_places.hpp"

namespace vacuform {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(InkedPlaces, AreExactOnAQuadraticSurface) {
  FormedSheet sheet;
  const auto place = [](const Vector2d& p) {
    return Vector3d(p.x() + 0.01 * p.y() * p.y(), p.y(), 30 - 0.02 * p.squaredNorm() + 0.01 * p.x() * p.y());
  };
  const int side = 9;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      sheet.rest.push_back(Vector2d(5 * i, 5 * j));
      sheet.formed.push_back(place(sheet.rest.back()));
      sheet.thickness.push_back(0.7);
      if (i == 0 || j == 0) continue;
      const int d = j * side + i, c = d - 1, b = d - side, a = b - 1;
      if ((i + j) % 2) {
        sheet.triangles.push_back({a, b, d}), sheet.triangles.push_back({a, d, c});
      } else {
        sheet.triangles.push_back({a, b, c}), sheet.triangles.push_back({b, d, c});
      }
    }
  const std::vector<Vector2d> rest{{17.3, 21.9}, {20, 20}, {22.2, 16.1}, {99, 0}};
  const VectorXd inner = inked_places(sheet, InkedFace::inner, rest),
                 outer = inked_places(sheet, InkedFace::outer, rest);
  for (Index i = 0; i < 3; ++i) {
    EXPECT_LT((inner.segment<3>(3 * i) - place(rest[static_cast<std::size_t>(i)])).norm(), 1e-9);
    EXPECT_NEAR((outer - inner).segment<3>(3 * i).norm(), 0.7, 0.01);
    EXPECT_GT((outer - inner)[3 * i + 2], 0.4);
  }
  EXPECT_TRUE(std::isnan(inner[9]));
}

// Formed places that are linear in three parameters, of which the points see the second and third almost only as a sum;
// every forming adds an error of its own that is smooth over the points.
class LinearSheet {
 public:
  explicit LinearSheet(double error_mm) : error_mm_(error_mm) {
    for (double s = -70; s <= 70; s += 14)
      for (double t = -70; t <= 70; t += 14) rest_.push_back({s, t});
  }
  VectorXd places(const VectorXd& t, double spacing) {
    VectorXd out(3 * static_cast<Index>(rest_.size()));
    Eigen::Matrix<double, 3, 4> wave;
    for (Index i = 0; i < wave.size(); ++i) wave(i) = error_mm_ * spacing * spacing * normal_(random);
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const double x = rest_[i].x() / 70, y = rest_[i].y() / 70, sum = t[1] + t[2];
      const double grid = 0.05 * spacing * spacing * x * x * x;
      const Vector3d noise = wave * Eigen::Vector4d(x * x, y * y, x * x * x, x * y);
      out.segment<3>(3 * static_cast<Index>(i)) =
          Vector3d(70 * x + 0.06 * sum * x * x * x, 70 * y + 0.002 * t[2] * y * y * x,
                   -40 * (x * x + y * y) + 0.1 * t[0] * x * y + grid) +
          noise;
    }
    return out;
  }
  double normal() { return normal_(random); }
  std::mt19937 random{3};

 private:
  double error_mm_;
  std::vector<Vector2d> rest_;
  std::normal_distribution<double> normal_{0, 1};
};

struct Coverage {
  int held = 0, of = 0;
  double prior_share =
      0;  // of the last fit: posterior over prior, of the parameters that only count as a sum
};

// The same design and fit as calibrate()'s, of `parts` machines drawn from the prior.
Coverage coverage(double error_mm, int parts) {
  LinearSheet sheet(error_mm);
  Coverage out;
  FitProblem problem;
  problem.centre = problem.prior_mean = VectorXd::Zero(3);
  problem.half_width = VectorXd::Constant(3, 8);
  problem.prior_sd = Vector3d(5, 4, 4);
  problem.low = VectorXd::Constant(3, -100), problem.high = VectorXd::Constant(3, 100);
  const Eigen::Isometry3d frame =
      Eigen::Translation3d(20, -9, 300) * Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized());
  const auto design = central_composite(3);
  for (int part = 0; part < parts; ++part) {
    MatrixXd outputs(static_cast<Index>(design.size()), sheet.places(problem.centre, 0).size());
    for (std::size_t i = 0; i < design.size(); ++i)
      outputs.row(static_cast<Index>(i)) =
          sheet.places(design[i].u.cwiseProduct(problem.half_width), design[i].spacing).transpose();
    VectorXd truth(3);
    for (Index k = 0; k < 3; ++k) truth[k] = problem.prior_sd[k] * sheet.normal();
    const VectorXd formed = sheet.places(truth, 0);
    problem.measured.clear();
    for (Index i = 0; i < formed.size(); i += 3)
      problem.measured.push_back(
          frame * (formed.segment<3>(i) + 0.15 * Vector3d(sheet.normal(), sheet.normal(), sheet.normal())));
    const BayesianFit fit = bayesian_fit(problem, ResponseSurface(design, outputs));
    EXPECT_TRUE(fit.converged);
    for (Index k = 0; k < 3; ++k) {
      const double reach = interval_95(fit.freedom[k]) * std::sqrt(fit.covariance(k, k));
      out.held += std::abs(fit.t[k] - truth[k]) <= reach, ++out.of;
    }
    out.prior_share = std::sqrt(fit.covariance(1, 1)) / problem.prior_sd[1];
    EXPECT_LT(fit.covariance(1, 2), -0.5 * std::sqrt(fit.covariance(1, 1) * fit.covariance(2, 2)));
    EXPECT_LT(std::sqrt(fit.covariance(1, 1) + fit.covariance(2, 2) + 2 * fit.covariance(1, 2)), 3);
  }
  return out;
}

TEST(BayesianFit, CoversTheTruthAtTheStatedLevel) {
  const Coverage exact = coverage(0, 100), rough = coverage(0.03, 100);
  for (const Coverage& c : {exact, rough}) {
    EXPECT_GE(c.held, 274) << "of " << c.of;  // 285 of 300 expected; fewer than 274 in 1 of 400 samples
    EXPECT_LE(c.held, 297) << "of " << c.of;  // nor so wide that they say nothing
    EXPECT_GT(c.prior_share, 0.6);            // what the points cannot tell apart stays at the prior
    EXPECT_LE(c.prior_share, 1);
  }
}

TEST(BayesianFit, WidensTheIntervalForFewDegreesOfFreedom) {
  EXPECT_NEAR(interval_95(1e9), 1.96, 1e-3);
  EXPECT_NEAR(interval_95(7), 2.365, 0.01);
  EXPECT_NEAR(interval_95(5), 2.571, 0.03);
}

// A machine that is not as it was said: 8 mm higher, 6 mm narrower, 4 mm less deep, half as stiff again at the frame. Its
// part is simulated on a finer grid and measured on the face that carries the ink with 0.2 mm of noise; some points are
// plainly wrong.
struct Simulated {
  Prepared prepared{hemisphere(60, 45, 90), TemperatureField(140)};
  Settings given;
  std::vector<MeasuredPoint3> points;
  Eigen::Isometry3d frame =
      Eigen::Translation3d(40, -300, 120) * Eigen::AngleAxisd(0.7, Vector3d(1, -2, 3).normalized());

  explicit Simulated(InkedFace face, double reach, bool registered,
                     MembraneLaw law = MembraneLaw::neo_hookean, double grid_mm = 6,
                     double real_grid_mm = 4) {
    given.forming.law = law;
    if (registered) frame = Eigen::Isometry3d::Identity();
    given.sheet.width_mm = given.sheet.height_mm = 220;
    given.sheet.resolution_mm = grid_mm;
    given.machine.window_width_mm = given.machine.window_height_mm = 200;
    given.pattern.inked_face = face;
    Settings real = given;
    real.sheet.resolution_mm = real_grid_mm;
    real.machine.drape_height_mm = 8;
    real.machine.window_width_mm = 194, real.machine.window_height_mm = 196;
    real.forming.edge_stiffness = 1.5;
    const auto part =
        form(prepared.mold, real.sheet, real.machine, real.forming, prepared.temperature, Context{});
    std::vector<Vector2d> rest;
    for (double s = -reach; s <= reach; s += 10)
      for (double t = -reach; t <= reach; t += 10) rest.push_back({s, t});
    const VectorXd places = inked_places(*part, face, rest);
    std::mt19937 random(11);
    std::normal_distribution<double> noise(0, 0.2);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      Vector3d place = places.segment<3>(3 * static_cast<Index>(i));
      for (int k = 0; k < 3; ++k) place[k] += noise(random);
      if (i % 50 == 7) place += Vector3d(6, -3, 4);
      points.push_back({rest[i], frame * place});
    }
  }
};

// One law of the membrane on two grids, and the standard errors that its points allow. A law that hardens spreads the
// stretch, so the points tell the window less, and a coarse grid less well.
struct LawCase {
  MembraneLaw law;
  double grid_mm, real_grid_mm;
  std::array<double, 4> standard_errors;
};

class Calibration : public testing::TestWithParam<LawCase> {};

INSTANTIATE_TEST_SUITE_P(Laws, Calibration,
                         testing::Values(LawCase{MembraneLaw::neo_hookean, 6, 4, {0.65, 2.3, 2.1, 0.08}},
                                         LawCase{MembraneLaw::mooney_rivlin, 4, 3, {0.8, 3.5, 3.5, 0.08}}),
                         [](const auto& row) {
                           return row.param.law == MembraneLaw::neo_hookean ? "NeoHookean" : "MooneyRivlin";
                         });

// A machine that is not as it was said: 8 mm higher, 6 mm narrower, 4 mm less deep, half as stiff again at the frame. Its
// part is formed on a finer grid than the fit's, so the fit bears the simulation's error too: it tells the window least.
TEST_P(Calibration, RecoversASimulatedMachine) {
  const auto& [law, grid_mm, real_grid_mm, error] = GetParam();
  const Simulated part(InkedFace::outer, 90, false, law, grid_mm, real_grid_mm);
  const auto found = calibrate(part.prepared, part.given, part.points, {}, Context{});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_TRUE(found->converged);
  EXPECT_GT(found->before.mean, 1);
  EXPECT_LT(found->after.mean,
            0.65);  // noise of 0.2 mm is 0.32 mm in space; wild points and the grid of 6 mm add theirs
  EXPECT_EQ(found->after.count, part.points.size());
  EXPECT_GE(found->outliers, 7);
  ASSERT_EQ(found->parameters.size(), 4u);
  const double wanted[] = {8, 194, 196, 1.5};
  // The prior, whose mean is wrong here by a standard deviation and more, pulls all of them towards it: by its information
  // times the covariance of the result. Apart from that each lies within its standard error, grids of 6 mm included.
  VectorXd standard_error(4), pull(4);
  for (std::size_t k = 0; k < 4; ++k) {
    const FittedParameter& p = found->parameters[k];
    const auto at = static_cast<Index>(k);
    standard_error[at] = p.standard_error / (p.logarithmic ? p.value : 1);
    pull[at] =
        (p.prior - (p.logarithmic ? std::log(wanted[k]) : wanted[k])) / (p.prior_error * p.prior_error);
  }
  pull = standard_error.cwiseProduct(found->correlation * standard_error.cwiseProduct(pull)).eval();
  for (std::size_t k = 0; k < 4; ++k) {
    const FittedParameter& p = found->parameters[k];
    const auto at = static_cast<Index>(k);
    const double off = p.logarithmic ? std::log(p.value / wanted[k]) : p.value - wanted[k];
    EXPECT_NEAR(off, pull[at], standard_error[at]) << p.name;
    EXPECT_GT(p.standard_error, 0) << p.name;
    EXPECT_LT(p.standard_error, error[k]) << p.name;
    EXPECT_LT(p.low95, wanted[k]) << p.name;
    EXPECT_GT(p.high95, wanted[k]) << p.name;
    EXPECT_FALSE(p.at_bound) << p.name;
  }
  // The parameters trade off, so together they say more than each alone: how far all of them are off, in standard errors
  // of the direction in which they are. In four directions, 3.1 in one case of twenty.
  VectorXd off(4);
  for (Index k = 0; k < 4; ++k) {
    const FittedParameter& p = found->parameters[static_cast<std::size_t>(k)];
    off[k] = (p.value - wanted[k]) / p.standard_error;
  }
  EXPECT_LT(std::sqrt(off.dot(found->correlation.ldlt().solve(off))), 2.5);
  EXPECT_LT((found->motion * part.frame).translation().norm(), 0.5);

  const auto written =
      nlohmann::json::parse(R"({"machine": {"window_width_mm": 200, "vacuum_kpa": 60}, "print": {}})");
  const auto profile = profile_json(*found, written);
  EXPECT_EQ(profile["machine"]["vacuum_kpa"].get<double>(), 60);
  EXPECT_NEAR(profile["machine"]["window_width_mm"].get<double>(), found->parameters[1].value, 1e-3);
  EXPECT_FALSE(profile.contains("print"));
  EXPECT_EQ(profile["calibration"]["residual_mm"]["count"].get<std::size_t>(), part.points.size());
  EXPECT_EQ(profile["calibration"]["correlation"]["matrix"][1][1].get<double>(), 1);
  auto settings = nlohmann::json::parse(profile.dump());
  settings.erase("calibration");
  EXPECT_TRUE(settings_from_json(settings));
  EXPECT_NE(text_of(*found).find("machine.window_width_mm"), std::string::npos);
}

// On the top of the dome alone the window hardly shows. What the points do not tell is said, and stays at the prior.
TEST(CalibrationReport, NamesWhatThePointsDoNotTell) {
  const Simulated part(InkedFace::outer, 50, true);
  CalibrationOptions options;
  options.registered = true;
  const auto found = calibrate(part.prepared, part.given, part.points, options, Context{});
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_FALSE(found->unresolved.empty());
  EXPECT_NE(found->unresolved[0].text.find("machine.window_"), std::string::npos)
      << found->unresolved[0].text;
  EXPECT_NE(text_of(*found).find("not told apart"), std::string::npos);
  // The sheet is 0.5 to 1 mm thick: compared with its other face the registered points do not fit by as much.
  EXPECT_LT(found->after.mean, 0.6);
  const double wanted[] = {8, 194, 196, 1.5};
  for (std::size_t k = 0; k < 4; ++k) {
    const FittedParameter& p = found->parameters[k];
    EXPECT_LT(p.low95, wanted[k]) << p.name;
    EXPECT_GT(p.high95, wanted[k]) << p.name;
    EXPECT_GE(p.points_error, p.standard_error) << p.name;
  }
  EXPECT_GT(found->parameters[1].standard_error, 2);  // of a prior of 5
}

TEST(CalibrationReport, RefusesAPriorThatIsUnknownOrNotPositive) {
  const Prepared prepared{hemisphere(60, 45, 90), TemperatureField(140)};
  for (const auto& [name, error] : {std::pair("machine.vacuum_kpa", 1.0), {"machine.drape_height_mm", 0.0}}) {
    CalibrationOptions options;
    options.prior_errors[name] = error;
    const auto found = calibrate(prepared, {}, {}, options, Context{});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().where, name);
  }
}

}  // namespace
}  // namespace vacuform
