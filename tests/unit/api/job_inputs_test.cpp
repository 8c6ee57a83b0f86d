// Which files a job needs, may have and must not have, by its kind and its settings.
#include "api/job_inputs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace vacuform {
namespace {

using Names = std::vector<std::string_view>;

HasInput having(const Names& names) {
  return
      [names](std::string_view name) { return std::find(names.begin(), names.end(), name) != names.end(); };
}
// "" where the files are right, otherwise the code and where.
std::string checked(JobKind kind, const Names& names, Settings settings = {}) {
  use_inputs(having(names), settings);
  const auto right = check_inputs(kind, having(names), settings);
  if (right) return "";
  return (right.error().code == Code::bad_usage ? "bad_usage " : "bad_settings ") + right.error().where;
}

TEST(JobInputs, EveryKindOfJobNeedsItsFiles) {
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern"}), "");
  EXPECT_EQ(checked(JobKind::print, {"pattern"}), "bad_usage scan");
  EXPECT_EQ(checked(JobKind::print, {"scan"}), "bad_usage pattern");
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern", "icc"}), "");
  EXPECT_EQ(checked(JobKind::inspection, {"scan"}), "");
  EXPECT_EQ(checked(JobKind::layout, {"scan"}), "");
  Settings of_scan;
  of_scan.pattern.source = PatternSource::scan;
  EXPECT_EQ(checked(JobKind::print, {"scan"}, of_scan), "");
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern"}, of_scan), "bad_settings pattern.source");
}

TEST(JobInputs, AFileIsUsedWhereTheSettingsLeaveItOpenAndRefusedWhereTheyDoNot) {
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern", "temperature", "weights"}), "");
  EXPECT_EQ(checked(JobKind::layout, {"scan", "temperature"}), "");
  Settings other;
  other.heat.source = HeatSource::heaters;
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern", "temperature"}, other), "bad_settings heat.source");
  other = {};
  other.flattening.weights = FlatteningWeights::ink;
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern", "weights"}, other),
            "bad_settings flattening.weights");
}

TEST(JobInputs, AFileThatTheSettingsAskForIsMissedByTheJobsThatUseIt) {
  Settings asking;
  asking.heat.source = HeatSource::measured;
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern"}, asking), "bad_settings heat.source");
  EXPECT_EQ(checked(JobKind::layout, {"scan"}, asking), "bad_settings heat.source");
  EXPECT_EQ(checked(JobKind::inspection, {"scan"}, asking), "");
  asking = {};
  asking.flattening.weights = FlatteningWeights::painted;
  EXPECT_EQ(checked(JobKind::print, {"scan", "pattern"}, asking), "bad_settings flattening.weights");
}

TEST(JobInputs, TheGridInForceIsHalfAsWideForFineForming) {
  Settings s;
  s.sheet.resolution_mm = 3;
  EXPECT_EQ(grid_spacing_mm(s), 3);
  s.forming.quality = FormingQuality::fine;
  EXPECT_EQ(grid_spacing_mm(s), 1.5);
}

}  // namespace
}  // namespace vacuform
