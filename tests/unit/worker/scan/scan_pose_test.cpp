// Which way is up, how far a scan is tilted, and the trim of noisy scans.
#include <gtest/gtest.h>

#include <random>

#include "tests/unit/worker/scan/scan_shapes.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/poses.hpp"
#include "worker/scan/smoothing.hpp"
#include "worker/scan/symmetry.hpp"
#include "worker/scan/upright.hpp"

namespace vacuform::scan_pose_test {
namespace {

using namespace shapes;
using Eigen::Vector3d;
constexpr double degree = std::numbers::pi / 180;

// A head 190 mm high without ears: a flat neck at z = 0, narrower than the skull, longer in front than behind.
TriangleMesh lathe_head() {
  std::vector<Eigen::Vector2d> profile{{0, 0}, {20, 0}, {44, 0}};
  for (double z = 5; z <= 60; z += 5)
    profile.emplace_back(48 + 27 * std::pow(std::sin(z / 115 * 90 * degree), 4), z);
  for (double z = 65; z <= 115; z += 5)
    profile.emplace_back(48 + 27 * std::pow(std::sin(z / 115 * 90 * degree), 4), z);
  for (double a = 4; a < 90; a += 4)
    profile.emplace_back(75 * std::cos(a * degree), 115 + 75 * std::sin(a * degree));
  profile.emplace_back(0, 190);
  auto head = lathe(profile, 96);
  for (auto& p : head.vertices) p.y() *= p.y() > 0 ? 1.35 : 1.1;
  return head;
}

TriangleMesh noisy(TriangleMesh mesh, double sigma) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, sigma);
  for (auto& p : mesh.vertices) p += Vector3d(normal(random), normal(random), normal(random));
  return mesh;
}

Result<Mold> mold_of(const TriangleMesh& mesh, ScanSettings settings = {}) {
  settings.units = Unit::mm;
  return make_mold(stl(mesh), "scan.stl", settings, Context());
}

const Warning* warning_of(const Mold& mold, const std::string& code) {
  for (const Warning& w : mold.warnings)
    if (w.code == code) return &w;
  return nullptr;
}

const std::pair<UpAxis, Vector3d> directions[] = {{UpAxis::plus_x, {1, 0, 0}}, {UpAxis::minus_x, {-1, 0, 0}},
                                                  {UpAxis::plus_y, {0, 1, 0}}, {UpAxis::minus_y, {0, -1, 0}},
                                                  {UpAxis::plus_z, {0, 0, 1}}, {UpAxis::minus_z, {0, 0, -1}}};

TEST(Pose, ConfidencesAddUpAndRankTheAxes) {
  const auto guess = guess_up(lathe_head(), ScanProgress(Context()));
  ASSERT_TRUE(guess);
  ASSERT_EQ(guess->candidates.size(), 6u);
  double sum = 0, last = 1;
  for (const auto& c : guess->candidates) {
    EXPECT_LE(c.confidence, last);
    last = c.confidence;
    sum += c.confidence;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_EQ(guess->best().axis, UpAxis::plus_z);
  EXPECT_GT(guess->best().confidence, 0.99);
  EXPECT_TRUE(guess->conclusive());
}

// Two flat ends that are alike, and none at all: the habit of exporters may choose, but not in silence.
TEST(Pose, WhatOnlyHabitDecidesIsAsked) {
  const TriangleMesh prism = lathe({{0, 0}, {40, 0}, {40, 150}, {0, 150}}, 48), egg = sphere(60, 48);
  for (const auto& [axis, direction] : directions)
    for (const TriangleMesh& mesh : {prism, egg}) {
      const auto mold = mold_of(fallen(mesh, direction), ScanSettings());
      ASSERT_TRUE(mold) << mold.error().text();
      EXPECT_TRUE(warning_of(*mold, "up-guessed")) << name(axis);
    }
}

TEST(Pose, AHeadWithoutItsCrownIsNotTurnedOverInSilence) {
  for (const double missing : {35.0, 70.0})
    for (const auto& [axis, direction] : directions) {
      const auto open = without(lathe_head(), [&](const auto& p) { return p.z() > 190 - missing; });
      const auto mold = mold_of(fallen(open, direction));
      ASSERT_TRUE(mold) << mold.error().text();
      const Warning* warning = warning_of(*mold, "up-guessed");
      EXPECT_TRUE(mold->findings.up == axis ||
                  (warning && warning->what_to_do().find("--set scan.up=" + std::string(name(axis))) !=
                                  std::string::npos))
          << missing << " " << name(axis) << " is " << name(mold->findings.up);
    }
}

TEST(Pose, FloatingPartsAndPitsDoNotTurnTheHead) {
  auto parts = lathe_head();
  parts = joined(std::move(parts), shifted(sphere(20, 16), 150, 20, 40));
  parts = joined(std::move(parts), shifted(sphere(25, 16), -40, -150, 120));
  auto pits = lathe_head();
  for (const Vector3d& at : {Vector3d(75, 10, 110), Vector3d(-60, 50, 90), Vector3d(10, -82, 120)})
    for (auto& p : pits.vertices)
      if (const double d = (p - at).norm(); d < 16) p -= (16 - d) * Vector3d(at.x(), at.y(), 0).normalized();
  for (const auto& [axis, direction] : directions)
    for (const auto& mesh : {parts, pits}) {
      const auto guess = guess_up(fallen(mesh, direction), ScanProgress(Context()));
      ASSERT_TRUE(guess);
      EXPECT_EQ(guess->best().axis, axis) << name(axis);
      EXPECT_TRUE(guess->conclusive()) << name(axis);
    }
}

// The head tilted about an odd axis: the warning has the angle, and the settings that it names stand the head upright.
TEST(Pose, ATiltIsToldWithTheTurnThatStraightensIt) {
  const Vector3d about = Vector3d(0.8, -0.6, 0);
  const auto open = without(lathe_head(), [](const auto& p) { return p.z() < 1; });
  for (const double angle : {0.0, 10.0, 30.0, 60.0})
    for (const auto& head : {lathe_head(), open}) {
      const Eigen::Affine3d turn(Eigen::AngleAxisd(angle * degree, about));
      const auto mold = mold_of(moved(head, turn));
      ASSERT_TRUE(mold) << mold.error().text();
      const Warning* warning = warning_of(*mold, "tilted");
      const Vector3d up = turn * Vector3d::UnitZ();
      const Vector3d stood = upright_turn(mold->findings.up, 0, 0, 0) * up;
      const double off = std::acos(stood.z()) / degree;
      ASSERT_EQ(warning != nullptr, off > 20) << angle;
      if (!warning) continue;
      EXPECT_NEAR(warning->figure->value, off, 0.5);
      ASSERT_EQ(warning->proposals.size(), 1u);
      const auto& set = warning->proposals[0].set;
      ASSERT_EQ(options_of(warning->proposals[0])
                    .find("--set scan.up=" + std::string(name(mold->findings.up)) + " --set scan.roll_deg="),
                0u);
      ScanSettings settings;
      settings.up = mold->findings.up;
      settings.roll_deg = set.at(1).number.value_or(0);
      settings.pitch_deg = set.at(2).number.value_or(0);
      const auto straight = mold_of(moved(head, turn), settings);
      ASSERT_TRUE(straight) << straight.error().text();
      EXPECT_FALSE(warning_of(*straight, "tilted"));
      const Vector3d crown = straight->placing(up) - straight->placing(Vector3d::Zero());
      EXPECT_GT(crown.z(), std::cos(0.5 * degree)) << angle;
    }
}

// Without a foot: an egg with a nose and a chin, mirrored in x = 0, tilted to one side.
TEST(Pose, AMedianPlaneTellsATiltToOneSide) {
  auto egg = sphere(60, 40);
  for (auto& p : egg.vertices) {
    const double nose = std::exp(-(p - Vector3d(0, 60, -5)).squaredNorm() / 200);
    const double chin = std::exp(-(p - Vector3d(0, 35, -48)).squaredNorm() / 400);
    p = Vector3d(0.8 * p.x(), 1.05 * p.y() + 14 * nose + 12 * chin, 1.1 * p.z() - 10 * chin);
  }
  const Vector3d normal = Eigen::AngleAxisd(25 * degree, Vector3d::UnitY()) * Vector3d::UnitX();
  const auto turned = moved(egg, Eigen::Affine3d(Eigen::AngleAxisd(25 * degree, Vector3d::UnitY())));
  const auto plane = MirrorTest(turned).best(ScanProgress(Context{})).value();
  EXPECT_GT(std::abs(plane.normal.dot(normal)), std::cos(1.5 * degree));
  EXPECT_LT(plane.error, 0.002);
  UpGuess guess;
  guess.side = plane.normal;
  const auto tilt = find_tilt(guess, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(tilt);
  EXPECT_NEAR(tilt->angle_deg, 25, 1.5);
  EXPECT_NEAR(tilt->roll_deg, 0, 1.5);
  EXPECT_NEAR(tilt->pitch_deg, -25, 1.5);
}

TEST(Noise, IsMeasuredAndSmoothed) {
  const auto head = lathe_head();
  const Context context;
  const ScanProgress progress(context);
  const auto clean = without_noise(head, 100, progress);
  ASSERT_TRUE(clean);
  EXPECT_FALSE(clean->has_value());
  auto ball = sphere(90, 60);
  EXPECT_LT(noise_of(ball), 0.05);
  for (const double sigma : {0.5, 2.0}) {
    const auto rough = noisy(ball, sigma);
    EXPECT_NEAR(noise_of(rough), sigma, 0.25 * sigma);
    const auto smooth = without_noise(rough, 90, progress);
    ASSERT_TRUE(smooth && smooth->has_value());
    double square = 0;
    int count = 0;
    for (const auto& p : (*smooth)->vertices)
      if (std::abs(p.z()) < 80) square += std::pow(p.norm() - 90, 2), ++count;
    EXPECT_LT(std::sqrt(square / count), 0.3 * sigma);
  }
}

// The height is measured from the lowest point, which noise lowers.
TEST(Noise, DoesNotMoveTheAutomaticTrim) {
  ScanSettings settings;
  settings.up = UpAxis::plus_z;
  const auto clean = mold_of(lathe_head(), settings);
  ASSERT_TRUE(clean) << clean.error().text();
  for (const double sigma : {0.5, 2.0}) {
    const auto head = noisy(lathe_head(), sigma);
    const auto mold = mold_of(head, settings);
    ASSERT_TRUE(mold) << mold.error().text();
    EXPECT_NEAR(mold->findings.trim_mm + bounds(head).low.z(), clean->findings.trim_mm, 3) << sigma;
  }
}

}  // namespace
}  // namespace vacuform::scan_pose_test
