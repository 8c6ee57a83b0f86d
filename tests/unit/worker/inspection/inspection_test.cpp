#include "worker/inspection/inspection.hpp"
#include "worker/inspection/heat_maps.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <bit>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/printed_jobs.hpp"
#include "tests/unit/fixtures/shapes.hpp"
#include "worker/inspection/callouts.hpp"
#include "worker/inspection/caption.hpp"
#include "worker/inspection/previews.hpp"
#include "worker/inspection/view.hpp"
#include "worker/scan/mold_distance.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using namespace printed_jobs;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Bytes& file(const std::vector<Artifact>& files, const std::string& name) {
  const auto found =
      std::find_if(files.begin(), files.end(), [&](const Artifact& a) { return a.name == name; });
  if (found == files.end()) throw std::runtime_error("no " + name);
  return found->bytes;
}

TEST(SingularValues, AreThoseOfKnownMaps) {
  const std::array<Vector2d, 3> from{Vector2d(1, 2), Vector2d(4, 2), Vector2d(2, 5)};
  const auto mapped = [&](const Eigen::Matrix<double, 3, 2>& J) {
    return std::array<Vector3d, 3>{J * from[0] + Vector3d(7, 8, 9), J * from[1] + Vector3d(7, 8, 9),
                                   J * from[2] + Vector3d(7, 8, 9)};
  };
  Eigen::Matrix<double, 3, 2> J;
  J << 3, 0, 0, 0.5, 0, 0;
  SingularValues s = singular_values(from, mapped(J));
  EXPECT_NEAR(s.largest, 3, 1e-12);
  EXPECT_NEAR(s.smallest, 0.5, 1e-12);
  J << 1, 0, 0, 1, 0, 0;
  s = singular_values(from, mapped(J));
  EXPECT_NEAR(s.largest, 1, 1e-7);
  EXPECT_NEAR(s.largest / s.smallest, 1, 1e-7);

  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    for (int k = 0; k < 6; ++k) J(k % 3, k / 3) = normal(random);
    const Vector2d expected = Eigen::JacobiSVD<Eigen::Matrix<double, 3, 2>>(J).singularValues();
    s = singular_values(from, mapped(J));
    EXPECT_NEAR(s.largest, expected[0], 1e-9);
    EXPECT_NEAR(s.smallest, expected[1], 1e-9);
  }
}

Distortion distortion_of(const FormedSheet& sheet, const Flattening& flattening, const CornersUv& uv) {
  return distortion(distortion_values(hand_made::inked(sheet), flattening.triangles, uv));
}

TEST(Distortion, EqualsTheStretchOfASheet) {
  Matrix2d stretch;
  stretch << 2, 0.3, 0, 1.25;
  const Sample x = hand_made::stretched(100, 10, stretch);
  const Vector2d s = Eigen::JacobiSVD<Matrix2d>(stretch).singularValues();
  const Distortion without =
      distortion_of(x.sheet, x.flattening, corners_of(x.sheet, x.flattening, x.sheet.rest));
  for (const double v : {without.shape.mean, without.shape.p95, without.shape.p99, without.shape.max})
    EXPECT_NEAR(v, s[0] / s[1], 1e-9);
  for (const double v : {without.area.mean, without.area.max}) EXPECT_NEAR(v, 2.5, 1e-9);
  const Distortion with =
      distortion_of(x.sheet, x.flattening, corners_of(x.sheet, x.flattening, x.flattening.chart));
  EXPECT_NEAR(with.shape.max, 1, 1e-6);
  EXPECT_NEAR(with.area.max, 1, 1e-9);
  // A shrunken area counts like a grown one, and neither a turn nor a shift of the pattern counts at all.
  std::vector<Vector2d> uv;
  for (const auto& st : x.sheet.rest)
    uv.push_back(2 * Vector2d(-(stretch * st).y(), (stretch * st).x()) + Vector2d(5, 9));
  const Distortion shrunk = distortion_of(x.sheet, x.flattening, corners_of(x.sheet, x.flattening, uv));
  EXPECT_NEAR(shrunk.area.mean, 4, 1e-9);
  EXPECT_NEAR(shrunk.shape.mean, 1, 1e-6);
}

TEST(Distortion, PercentilesAreByInkedArea) {
  // A strip of 100 squares that stretch by 1.01, 1.02, ... along x: the area of each is its stretch.
  FormedSheet sheet;
  Flattening flattening;
  double end = 0, total = 0;
  std::vector<double> stretch;
  for (int i = 0; i <= 100; ++i) {
    for (const double t : {0.0, 1.0}) {
      sheet.rest.emplace_back(i, t);
      sheet.formed.emplace_back(end, t, 3);
    }
    if (i == 100) break;
    stretch.push_back(1.01 + 0.01 * i);
    end += stretch.back(), total += stretch.back();
    const int a = 2 * i;
    sheet.triangles.insert(sheet.triangles.end(), {Triangle{a, a + 2, a + 3}, Triangle{a, a + 3, a + 1}});
    flattening.triangles.insert(flattening.triangles.end(), {a, a + 1});
  }
  const auto percentile = [&](double share) {
    double below = 0;
    for (const double v : stretch)
      if ((below += v) >= share * total) return v;
    return 0.0;
  };
  double mean = 0;
  for (const double v : stretch) mean += v * v / total;
  const Distortion d = distortion_of(sheet, flattening, corners_of(sheet, flattening, sheet.rest));
  EXPECT_NEAR(d.shape.mean, mean, 1e-9);
  EXPECT_NEAR(d.shape.p95, percentile(0.95), 1e-9);
  EXPECT_NEAR(d.shape.p99, percentile(0.99), 1e-9);
  EXPECT_NEAR(d.shape.max, 2.0, 1e-9);
  EXPECT_NEAR(d.area.p95, percentile(0.95), 1e-9);
  EXPECT_GT(d.shape.p95, 1.95);  // unweighted it would be 1.95
  const Distortion none = distortion({});
  EXPECT_EQ(none.shape.max, 0);
}

TEST(MoldDistance, IsExactOnAnOctahedron) {
  TriangleMesh mesh{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                    {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}};
  for (auto& p : mesh.vertices) p = 50 * p + Vector3d(1000, 0, 0);
  const MoldDistance distance(mesh);
  EXPECT_NEAR(distance({1000, 0, 0}), 50 / std::sqrt(3), 1e-9);   // inside, to a face
  EXPECT_NEAR(distance({1070, 0, 0}), 20, 1e-9);                  // to a corner
  EXPECT_NEAR(distance({1040, 40, 0}), 30 / std::sqrt(2), 1e-9);  // to an edge
  EXPECT_NEAR(distance({1050, 0, 0}), 0, 1e-12);
  EXPECT_EQ(MoldDistance(TriangleMesh{})({0, 0, 0}), INFINITY);
}

TEST(MoldDistance, DoesNotDependOnTheGuess) {
  const Mold mold = hemisphere(60, 30, 60);
  const MoldDistance distance(mold.mesh);
  int before = -1;
  for (int i = 0; i < 2000; ++i) {
    // Now and then far from the point before.
    const double angle = 0.01 * i + (i % 100 == 0 ? 2.0 : 0.0), radius = 20 + 0.1 * (i % 977);
    const Vector3d point(radius * std::cos(angle), radius * std::sin(angle), 0.05 * (i % 1500));
    const double exact = distance(point);
    EXPECT_EQ(distance(point, before), exact) << i;
    const auto near = distance.nearest(point, 1000, i % static_cast<int>(mold.mesh.triangles.size()));
    ASSERT_TRUE(near);
    EXPECT_EQ(near->distance_mm, exact) << i;
    EXPECT_EQ(distance.nearest(point, 0.99 * exact, before).has_value(), false) << i;
  }
}

TEST(Report, HoldsTheFiguresUnderStableKeys) {
  Job job = small_dome();
  job.sample.mold.warnings = {{"undercut", "There is an undercut.", {{{1, 2, 3.04}, 5}}}};
  job.sample.sheet.vents = {{{1.5, -2, 40}, 1}};
  job.print.warnings.push_back({"ink-off-chart", "5 % is lost."});
  const nlohmann::ordered_json r = report(job.finished());
  std::vector<std::string> groups;
  for (const auto& [key, value] : r.items()) groups.push_back(key);
  EXPECT_EQ(groups, (std::vector<std::string>{"settings", "scan", "mold", "heat", "forming", "thickness",
                                              "flattening", "pattern", "print", "figures", "histograms",
                                              "maps", "warnings", "vents", "artifacts"}));
  EXPECT_EQ(r["pattern"]["format"], "SVG");
  EXPECT_EQ(r["pattern"]["size_mm"], (nlohmann::json{60.0, 50.0}));
  EXPECT_NEAR(r["pattern"]["ink_area_mm2"].get<double>(), 2 * M_PI * 20 * 3, 0.5);
  EXPECT_EQ(r["pattern"]["ink_printed"], 1.0);
  EXPECT_EQ(r["pattern"]["ink_on_head"], 1.0);
  EXPECT_EQ(r["print"]["size_pixels"], (nlohmann::json{1182, 1182}));
  // The dome's own figures: on the meridian 1.197, around it falling to 0.844 at its foot.
  const auto& figures = r["figures"];
  EXPECT_NEAR(figures["without"]["area"]["max"].get<double>(), 1.43, 0.01);
  EXPECT_GT(figures["without"]["area"]["mean"].get<double>(), figures["with"]["area"]["mean"].get<double>());
  for (const char* side : {"with", "without"})
    for (const char* figure : {"shape", "area"})
      for (const char* statistic : {"mean", "p95", "p99", "max"})
        EXPECT_GE(figures[side][figure][statistic], 1.0);
  for (const auto& [figure, way] : {std::pair{"shape", "with"},
                                    {"shape", "without"},
                                    {"area", "with"},
                                    {"area", "without"},
                                    {"thickness_ratio", "shares"}}) {
    double sum = 0;
    for (const double share : r["histograms"][figure][way]) sum += share;
    EXPECT_NEAR(sum, 1, 0.002) << figure << " " << way;
  }
  const auto& thickness = job.sample.sheet.element_thickness;
  EXPECT_NEAR(r["thickness"]["least_ratio"].get<double>(),
              *std::min_element(thickness.begin(), thickness.end()), 1e-4);
  EXPECT_EQ(
      r["warnings"].dump(),
      R"([{"stage":"scan","code":"undercut","severity":"warning","what":"There is an undercut.",)"
      R"("place":"x = 1.0, y = 2.0, z = 3.0 mm","figure":null,)"
      R"("fix":"Trim the mold above the undercut (scan.trim_mm), or turn the scan.",)"
      R"("proposals":[],"marks":[{"place_mm":[1.0,2.0,3.0],"size_mm":5.0}]},)"
      R"({"stage":"printing","code":"ink-off-chart","severity":"serious","what":"5 % is lost.",)"
      R"("place":"the drawing","figure":null,)"
      R"("fix":"Move or scale the drawing (pattern.offset_mm, pattern.scale).","proposals":[],"marks":[]}])");
  EXPECT_EQ(r["vents"].dump(), R"([{"place_mm":[1.5,-2.0,40.0],"diameter_mm":1.0}])");
  std::size_t listed = 0;
  for (const auto& kind : artifact_kinds)
    if (kind.always) {
      ASSERT_LT(listed, r["artifacts"].size());
      EXPECT_EQ(r["artifacts"][listed++]["name"], kind.name);
    }
  EXPECT_EQ(listed, r["artifacts"].size());
  EXPECT_EQ(r["heat"]["source"], "uniform");
}

TEST(Report, MeasuresHowFarFormedVerticesLieFromTheMold) {
  Job job = small_dome();
  // The vertices lie on the sphere, the mold's facets of 2 degrees inside it: at most R (1 - cos 2.24) =
  // 0.046 mm apart.
  const auto forming = report(job.finished())["forming"];
  EXPECT_GT(forming["vertex_gap_mm"], 0.001);
  EXPECT_LT(forming["vertex_gap_mm"], 0.046);
  // One vertex off by half a millimetre is found.
  const auto top = std::min_element(job.sample.sheet.rest.begin(), job.sample.sheet.rest.end(),
                                    [](const auto& a, const auto& b) { return a.norm() < b.norm(); }) -
                   job.sample.sheet.rest.begin();
  job.sample.sheet.formed[static_cast<std::size_t>(top)].z() += 0.5;
  EXPECT_NEAR(report(job.finished())["forming"]["vertex_gap_mm"].get<double>(), 0.5, 0.001);
}

TEST(Report, SaysHowTheSheetLiesOnTheMold) {
  Job job = small_dome();
  job.sample.sheet.fit.penetration = {0.01, 1.25, {1, 2, 30}};
  job.sample.sheet.fit.gap = {0.02, 0.5, {4, 5, 6}};
  const auto forming = report(job.finished())["forming"];
  EXPECT_EQ(forming["penetration_mm"].dump(), R"({"p99":0.01,"max":1.25,"place_mm":[1.0,2.0,30.0]})");
  EXPECT_EQ(forming["gap_mm"].dump(), R"({"p99":0.02,"max":0.5,"place_mm":[4.0,5.0,6.0]})");
  int on_mold = 0;
  for (const Contact c : job.sample.sheet.contact) on_mold += c == Contact::mold;
  EXPECT_EQ(forming["vertices_by_contact"]["mold"], on_mold);
}

TEST(Report, WritesWhatIsNotANumberAsNull) {
  Job job = small_dome();
  job.sample.sheet.summary.residual = NAN;
  job.sample.sheet.summary.force_error = INFINITY;
  const auto forming = report(job.finished())["forming"];
  EXPECT_TRUE(forming["residual"].is_null());
  EXPECT_TRUE(forming["force_error"].is_null());
}

// A tower of 30 mm on a platform, on a grid of 2 mm.
TEST(View, ThePlatformHasNoShadowAndTheFootNoSteps) {
  TriangleMesh mesh;
  constexpr int n = 80;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vector2d p(2.0 * i - n, 2.0 * j - n);
      mesh.vertices.emplace_back(p.x(), p.y(), p.norm() < 20 ? 30.0 : 0.0);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  View view(mesh, mesh.vertices, {}, 300, 300, 0, 0);
  view.look_from(View::Side::above, 300, 0, 0);
  std::vector<std::pair<double, float>> platform;
  std::mutex mutex;
  ASSERT_TRUE(view.draw(
      1,
      [&](const Seen& seen, Rgb* colour) {
        *colour = Rgb(0, 0, 0);
        Vector3d place(0, 0, 0);
        for (std::size_t k = 0; k < 3; ++k)
          place += seen.weights[k] * mesh.vertices[static_cast<std::size_t>(
                                         mesh.triangles[static_cast<std::size_t>(seen.triangle)][k])];
        const std::lock_guard hold(mutex);
        platform.emplace_back(place.head<2>().norm(), seen.light);
      },
      Context(), 0, 1));
  float darkest = 10, brightest = 0;
  for (const auto& [r, light] : platform)
    if (r > 45 && r < 75) darkest = std::min(darkest, light), brightest = std::max(brightest, light);
  EXPECT_GT(platform.size(), 10000u);
  EXPECT_GT(darkest, 0.99f * brightest);
  // Just beside the foot, all around, no band is much darker than its neighbours.
  float low = 10, high = 0;
  for (const auto& [r, light] : platform)
    if (r > 30 && r < 32) low = std::min(low, light), high = std::max(high, light);
  EXPECT_GT(low, 0.8f * high);
}

TEST(Artifacts, AreAllOfThemInOrder) {
  const Job job = small_dome();
  const auto files = artifacts(job.finished(), Context());
  ASSERT_TRUE(files);
  std::vector<std::string> names, expected;
  for (const auto& f : *files) {
    names.push_back(f.name);
    EXPECT_FALSE(f.bytes.empty()) << f.name;
  }
  for (const auto& kind : artifact_kinds)
    if (kind.always && !kind.name.starts_with("report.")) expected.emplace_back(kind.name);
  EXPECT_EQ(names, expected);
  EXPECT_EQ(file(*files, "print.png"), job.print.main().files.png);
}

// An unevenly warm sheet and a drawing in segments: temperatures and segments are in the report, and previews show them.
TEST(Artifacts, ShowTheTemperatureAndTheSegmentsWhereThereAreAny) {
  Job job = small_dome();
  for (std::size_t v = 0; v < job.sample.sheet.rest.size(); ++v)
    job.sample.sheet.temperature[v] = 140 + 0.3 * job.sample.sheet.rest[v].x();
  job.sample.settings.pattern.placement = PatternPlacement::segments;
  job.sample.settings.pattern.distortion_limit = 10;
  job.placement = *place(hand_made::Charted(job.sample), nullptr, job.sample.settings, Context());
  Finished finished = job.finished();
  finished.heat = {HeatSource::heaters, 120, 140, 160, 31.25, 2.5};
  // 10 % longer above the middle of the page, and as drawn below it.
  LengthErrors& lengths = finished.lengths;
  lengths.pieces = {{0.1, 0, 20, 0, {{-10, 5}, {10, 5}}, {1, 2, 3}},
                    {0, 0, 20, 0, {{-10, -5}, {10, -5}}, {1, 2, 3}}};
  lengths.worst = 0.1;
  job.print.layers.push_back(
      {.name = "colours", .source = job.print.main().source, .files = {{1}, "<svg/>", {2}}});
  const auto files = artifacts(finished, Context());
  ASSERT_TRUE(files);
  const auto r = report(finished);
  EXPECT_EQ(r["heat"].dump(),
            R"({"source":"heaters","window_c":[121.0,160.0],"least_c":120.0,"mean_c":140.0,"most_c":160.0,)"
            R"("seconds":31.25,"through_thickness_c":2.5})");
  // The files of the colours are made too, without the comparison with the scan. The two reports are made of the whole;
  // findings.json is an inspection's, pattern.svg and layout.json a layout's.
  const auto made_of_others = [](std::string_view name) {
    for (const char* of_scan :
         {"preview-original.", "preview-position.", "preview-colour.", "preview-align."})
      if (name.starts_with(of_scan)) return true;
    for (const char* of_array : {"print-", "layers.", "coils.", "array"})
      if (name.starts_with(of_array)) return true;
    return false;
  };
  const std::size_t others = static_cast<std::size_t>(
      std::count_if(artifact_kinds.begin(), artifact_kinds.end(),
                    [&](const ArtifactKind& kind) { return made_of_others(kind.name); }));
  ASSERT_EQ(files->size() + 5 + others, artifact_kinds.size());
  ASSERT_EQ(r["artifacts"].size() + 3 + others, artifact_kinds.size());
  std::size_t next = 0;
  for (const ArtifactKind& kind : artifact_kinds)
    if (!made_of_others(kind.name) && next < files->size()) {
      EXPECT_EQ((*files)[next].name, kind.name);
      ++next;
    }
  for (const char* name : {"preview-temperature.png", "preview-segments.png"})
    EXPECT_EQ(decode_png(file(*files, name)).width, 1000);
  const Decoded picture = decode_png(file(*files, "preview-lengths.png"));
  const Vector2d size = job.pattern.size_mm();
  const int middle = (caption_top + 1000 - caption_bottom) / 2;
  const int away =
      static_cast<int>(5 * std::min(920 / size.x(), (1000 - caption_top - caption_bottom - 60) / size.y()));
  const auto colour_at = [&](int y) {
    return std::array{picture.at(500, y, 0), picture.at(500, y, 1), picture.at(500, y, 2)};
  };
  EXPECT_EQ(colour_at(middle - away), (std::array{0x7f, 0x3b, 0x08}));
  EXPECT_EQ(colour_at(middle + away), (std::array{0xf7, 0xf7, 0xf7}));
  EXPECT_EQ(r["segments"]["count"], 1);
  EXPECT_NEAR(r["segments"]["segments"][0]["distortion"].get<double>(), job.placement.charts[0].distortion,
              1e-4);
}

// A black ring over a red square: pictures show the lower layer where the upper one has no ink, and their colours.
TEST(SheetPicture, ShowsLayersOverEachOther) {
  Job job = small_dome();
  const Pattern square = *Pattern::read(
      bytes_of("<svg xmlns='http://www.w3.org/2000/svg' width='60mm' height='50mm' viewBox='-30 -25 60 50'>"
               "<rect x='-25' y='-5' width='50' height='10' fill='#c00'/></svg>"),
      "square", job.sample.settings.pattern, job.sample.settings.print.dpi);
  EXPECT_TRUE(in_black(job.print));
  job.print.layers.push_back(
      {.name = "colours", .source = picture_layer(square, job.placement, nullptr, false)});
  EXPECT_FALSE(in_black(job.print));
  const Finished finished = job.finished();
  const SheetPicture picture(finished);
  // The places of the sheet where the drawing has these coordinates.
  const auto seen = [&](const Vector2d& uv) {
    const auto& triangles = job.sample.flattening.triangles;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const auto& corners = job.print.pattern_uv[i];
      Matrix2d sides;
      sides << corners[1] - corners[0], corners[2] - corners[0];
      const Vector2d weights = sides.inverse() * (uv - corners[0]);
      if (weights.minCoeff() < 0 || weights.sum() > 1) continue;
      const Triangle& t = job.sample.sheet.triangles[static_cast<std::size_t>(triangles[i])];
      const auto rest = [&](std::size_t k) { return job.sample.sheet.rest[static_cast<std::size_t>(t[k])]; };
      const Vector2d at = rest(0) + weights.x() * (rest(1) - rest(0)) + weights.y() * (rest(2) - rest(0));
      return std::pair(picture.sample(at, 0.05), picture.over_lower(Ink{0, 1, 0, 0.5F}, at, 0.05));
    }
    throw std::runtime_error("off the chart");
  };
  const auto [ring, half_over] = seen({20, 0});
  EXPECT_NEAR(ring.r, 0, 0.01);
  EXPECT_NEAR(ring.a, 1, 0.01);
  EXPECT_NEAR(half_over.a, 1, 0.01);  // half green, the rest red from below
  EXPECT_NEAR(half_over.g, 0.5, 0.01);
  EXPECT_NEAR(half_over.r, 0.4, 0.01);
  const Ink red = seen({0, 0}).first;
  EXPECT_NEAR(red.r, 0.8, 0.01);
  EXPECT_NEAR(red.a, 1, 0.01);
  EXPECT_NEAR(seen({0, 12}).first.a, 0, 0.01);
}

TEST(Artifacts, AreTheSameBytesTwice) {
  const Job job = small_dome();
  const auto a = artifacts(job.finished(), Context()), b = artifacts(job.finished(), Context());
  ASSERT_TRUE(a && b);
  for (std::size_t i = 0; i < a->size(); ++i) EXPECT_TRUE((*a)[i].bytes == (*b)[i].bytes) << (*a)[i].name;
}

TEST(Artifacts, CanBeCancelled) {
  const Job job = small_dome();
  Context context;
  context.cancel();
  const auto files = artifacts(job.finished(), context);
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().code, Code::cancelled);
}

TEST(Artifacts, ThePlyReadsBackExactly) {
  const Job job = small_dome();
  const auto files = artifacts(job.finished(), Context());
  const Bytes ply = file(*files, "formed.ply");
  const std::string text(ply.begin(), ply.end());
  const auto body = text.find("end_header\n") + 11;
  const FormedSheet& sheet = job.sample.sheet;
  EXPECT_EQ(text.substr(0, body),
            "ply\nformat binary_little_endian 1.0\ncomment Vacuform formed sheet, mm, degrees "
            "Celsius\nelement vertex 1681\n"
            "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float "
            "t\nproperty float u\n"
            "property float v\nproperty float thickness\nproperty float temperature\nproperty uchar contact\n"
            "element face 3200\nproperty list uchar int vertex_indices\nend_header\n");
  ASSERT_EQ(ply.size(), body + 37 * sheet.formed.size() + 13 * sheet.triangles.size());
  const auto word = [&](std::size_t at) {
    return std::uint32_t{ply[at]} | std::uint32_t{ply[at + 1]} << 8 | std::uint32_t{ply[at + 2]} << 16 |
           std::uint32_t{ply[at + 3]} << 24;
  };
  std::vector<Vector2d> uv(sheet.formed.size(), Vector2d::Constant(NAN));
  for (std::size_t i = 0; i < job.print.pattern_uv.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      uv[static_cast<std::size_t>(
          sheet.triangles[static_cast<std::size_t>(job.sample.flattening.triangles[i])][k])] =
          job.print.pattern_uv[i][k];
  int off_chart = 0;
  for (std::size_t i = 0; i < sheet.formed.size(); ++i) {
    const std::size_t at = body + 37 * i;
    const auto value = [&](std::size_t k) { return std::bit_cast<float>(word(at + 4 * k)); };
    for (int k = 0; k < 3; ++k)
      ASSERT_EQ(value(static_cast<std::size_t>(k)), static_cast<float>(sheet.formed[i][k]));
    ASSERT_EQ(value(3), static_cast<float>(sheet.rest[i].x()));
    ASSERT_EQ(value(4), static_cast<float>(sheet.rest[i].y()));
    if (uv[i].allFinite()) {
      ASSERT_EQ(value(6), static_cast<float>(uv[i].y()));
    } else {
      ASSERT_TRUE(std::isnan(value(5)) && std::isnan(value(6)));
      ++off_chart;
    }
    ASSERT_EQ(value(7), static_cast<float>(sheet.thickness[i]));
    ASSERT_EQ(value(8), 130.0f);
    ASSERT_EQ(ply[at + 36], static_cast<std::uint8_t>(sheet.contact[i]));
  }
  EXPECT_GT(off_chart, 1000);
  const std::size_t faces = body + 37 * sheet.formed.size();
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    ASSERT_EQ(ply[faces + 13 * t], 3);
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_EQ(word(faces + 13 * t + 1 + 4 * k), static_cast<std::uint32_t>(sheet.triangles[t][k]));
  }
}

// The lines of an OBJ that begin with `key`, as numbers ("f 1/1 2/2 3/3" gives 1 1 2 2 3 3).
std::vector<std::vector<double>> lines(const Bytes& obj, const std::string& key) {
  std::vector<std::vector<double>> out;
  std::istringstream in(std::string(obj.begin(), obj.end()));
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key + " ")) continue;
    std::replace(line.begin(), line.end(), '/', ' ');
    std::istringstream numbers(line.substr(key.size()));
    out.emplace_back(std::istream_iterator<double>(numbers), std::istream_iterator<double>());
  }
  return out;
}

TEST(Artifacts, TheTexturedObjShowsThePrintWhereItIs) {
  for (const InkedFace face : {InkedFace::outer, InkedFace::inner}) {
    Sample x = hand_made::flat(120, 24);
    x.settings.print.marks = false;
    x.settings.pattern.inked_face = face;
    // One dot, 10 mm to the right of the middle and 5 mm to the back.
    const Job job(std::move(x), "<circle cx='10' cy='-5' r='3'/>");
    const auto files = artifacts(job.finished(), Context());
    const Bytes obj = file(*files, "formed.obj");
    const auto v = lines(obj, "v"), vt = lines(obj, "vt");
    ASSERT_EQ(v.size(), job.sample.sheet.formed.size());
    ASSERT_EQ(vt.size(), v.size());
    EXPECT_EQ(lines(obj, "f").size(), job.sample.sheet.triangles.size());
    const Decoded image = decode_png(job.print.main().files.png);
    int inked = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const int column = std::clamp(static_cast<int>(vt[i][0] * image.width), 0, image.width - 1);
      const int row = std::clamp(static_cast<int>((1 - vt[i][1]) * image.height), 0, image.height - 1);
      const bool under_dot = std::hypot(v[i][0] - 10, v[i][1] - 5) < 2.9;
      EXPECT_EQ(image.at(column, row) < 128, under_dot);
      inked += under_dot;
    }
    EXPECT_EQ(inked, 1);  // the vertex of the 5 mm grid at (10, 5)
  }
}

TEST(Artifacts, TheUvMapHoldsTheChartAndNormalisedPatternCoordinates) {
  const Job job = small_dome();
  const auto files = artifacts(job.finished(), Context());
  const Bytes obj = file(*files, "uv-map.obj");
  const auto v = lines(obj, "v"), vt = lines(obj, "vt"), f = lines(obj, "f");
  ASSERT_EQ(f.size(), job.sample.flattening.triangles.size());
  ASSERT_EQ(v.size(), vt.size());
  EXPECT_LT(v.size(), job.sample.sheet.formed.size());
  for (std::size_t i = 0; i < f.size(); ++i) {
    const auto& t = job.sample.sheet.triangles[static_cast<std::size_t>(job.sample.flattening.triangles[i])];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(f[i][2 * k]) - 1;
      ASSERT_EQ(f[i][2 * k], f[i][2 * k + 1]);
      ASSERT_NEAR(v[at][2], job.sample.sheet.formed[static_cast<std::size_t>(t[k])].z(), 1e-4);
      const Vector2d uv = job.print.pattern_uv[i][k];
      ASSERT_NEAR(vt[at][0], uv.x() / 60 + 0.5, 1e-6);
      ASSERT_NEAR(vt[at][1], uv.y() / 50 + 0.5, 1e-6);
    }
  }
}

TEST(Previews, ShowTheDrawingAndTheHeat) {
  const Job job = small_dome();
  const auto files = artifacts(job.finished(), Context());
  const auto dark = [&](const std::string& name) {
    const Decoded image = decode_png(file(*files, name));
    EXPECT_EQ(image.width, 1000);
    EXPECT_EQ(image.height, 1000);
    int count = 0;
    for (int y = caption_top; y < 1000 - caption_bottom; ++y)
      for (int x = 0; x < 1000; ++x)
        count += image.at(x, y, 0) < 60 && image.at(x, y, 1) < 60 && image.at(x, y, 2) < 60;
    return count;
  };
  // Undistorted, the same ring comes out smaller: the dome stretches the plain one by a fifth.
  const int plain = dark("preview-without.png"), corrected = dark("preview-with.png");
  EXPECT_GT(corrected, 10'000);
  EXPECT_GT(plain, 1.2 * corrected);
  const Decoded area = decode_png(file(*files, "preview-area.png"));
  int coloured = 0;
  for (int y = caption_top; y < 1000 - caption_bottom; ++y)
    for (int x = 0; x < 1000; ++x)
      coloured +=
          std::abs(area.at(x, y, 0) - area.at(x, y, 1)) + std::abs(area.at(x, y, 1) - area.at(x, y, 2)) > 40;
  EXPECT_GT(coloured, 200'000);
}

// Marks stand at their places in the colour of their code, the legend grows by a row for two of them, and what only
// shows from behind is shown from there.
TEST(Previews, FindingsAreMarkedWhereTheyAre) {
  Job job = small_dome();
  const Warning web{"webbing", "", {{{0, -52, 30}, 10}}};
  job.sample.sheet.warnings = {
      {"not-reached", "", {{{0, 0, 60}, 20}, {{20, 0, 56}, 20}}}, web, {"thin", "", {{{0, 52, 30}, 10}}}};
  const Finished finished = job.finished();
  const auto files = previews(finished, SheetPicture(finished), Context());
  ASSERT_TRUE(files);
  const Decoded marked = decode_png(file(*files, "preview-findings.png"));
  EXPECT_EQ(marked.width, 1000);
  EXPECT_EQ(marked.height, 1000 - caption_bottom + behind_height + 44 + 2 * 70);
  const View view(job.sample.sheet, {}, 1000, 1000, caption_top, caption_bottom);
  for (const auto& place : {Vector3d(0, 0, 60), Vector3d(20, 0, 56)}) {
    const auto spot = view.spot(place);
    ASSERT_TRUE(spot);
    EXPECT_LT(spot->behind_mm, 1);  // the second lies half a millimetre inside of the dome
    // Straight left of the place its ring of 20 mm is crossed, in the blue of Okabe and Ito; inside of it nothing is.
    const auto blue = [&](double mm) {
      int count = 0;
      const int y = static_cast<int>(spot->y), x = static_cast<int>(spot->x - mm * spot->pixels_per_mm);
      for (int dx = -3; dx <= 3; ++dx)
        count +=
            marked.at(x + dx, y, 0) == 0 && marked.at(x + dx, y, 1) == 114 && marked.at(x + dx, y, 2) == 178;
      return count;
    };
    EXPECT_GT(blue(10), 0);
    EXPECT_EQ(blue(5), 0);
  }
  EXPECT_GT(view.spot({0, 0, -30})->behind_mm, 30);
  Callouts callouts({web});
  EXPECT_FALSE(callouts.take_hidden(view).empty());
  EXPECT_TRUE(callouts.empty());
  // Just under the sheet at the back: deeper seen from the front.
  Callouts under({{"webbing", "", {{{0, -40, 30}, 10}}}});
  Callouts hidden = under.take_hidden(view);
  ASSERT_FALSE(hidden.empty());
  View turned(job.sample.sheet, {}, 1000, 1000, caption_top, caption_bottom);
  turned.look_from(View::Side::behind, 1000, caption_top, caption_bottom);
  EXPECT_TRUE(hidden.take_no_better(turned).empty());
  EXPECT_FALSE(hidden.take_no_better(view).empty());
}

TEST(Previews, WithoutFindingsSaySoInTheUsualSize) {
  Picture picture{1000, 1000, std::vector<std::uint32_t>(1'000'000, 0xffffffffu)};
  write_findings({{"up-guessed", "A warning without a place.", {}}}, picture, nullptr);
  EXPECT_EQ(picture.height, 1000);
  EXPECT_EQ(picture.pixels.size(), 1'000'000u);
}

TEST(HeatMaps, OfOneSettingHaveOneRangeAndColoursThatEndWithIt) {
  Job job = printed_jobs::small_dome();
  job.sample.settings.sheet.thickness_mm = 2;
  job.sample.settings.forming.thin_limit = 0.25;
  const std::vector<HeatMap> maps = heat_maps(job.finished());
  ASSERT_EQ(maps.size(), 4u);  // evenly warm, and without colours
  const HeatMap &shape = maps[0], &thickness = maps[2], &gap = maps[3];
  EXPECT_EQ(thickness.id, "thickness");
  EXPECT_EQ(thickness.low, 0.5);
  EXPECT_EQ(thickness.high, 2);
  EXPECT_NEAR(thickness.step, 0.2, 1e-12);
  const auto is = [](const Rgb& colour, int r, int g, int b) {
    EXPECT_NEAR((255 * colour - Rgb(r, g, b)).cwiseAbs().maxCoeff(), 0, 0.51) << colour.transpose();
  };
  is(thickness.colour(0.1), 0x00, 0x20, 0x4d);
  is(thickness.colour(3), 0xff, 0xea, 0x46);
  is(thickness.colour(0.5 + 1.5 / 9 * 3.5), (0x57 + 0x70) / 2, (0x5c + 0x71) / 2, (0x6d + 0x73) / 2);
  is(shape.colour(1), 0xf7, 0xf7, 0xf7);
  is(gap.colour(0), 0xff, 0xea, 0x46);  // bright where the sheet touches
  // Where there is no value: the chart has no place on the flat rim.
  EXPECT_TRUE(std::any_of(shape.values.begin(), shape.values.end(), [](double v) { return std::isnan(v); }));
  for (std::size_t v = 0; v < gap.values.size(); ++v) {
    const Contact contact = job.sample.sheet.contact[v];
    EXPECT_EQ(std::isnan(gap.values[v]), contact == Contact::platform || contact == Contact::clamp);
    if (contact == Contact::mold) {
      EXPECT_EQ(gap.values[v], 0);
    }
  }
  const auto json = heat_maps_json(maps);
  EXPECT_EQ(json[2]["title"], "Thickness of the formed sheet");
  EXPECT_EQ(json[2]["colours"][9], "#ffea46");
  EXPECT_EQ(json[2]["limit"], nullptr);
}

TEST(Previews, ASheetWithoutAChartIsStillShown) {
  Sample x = hand_made::flat(100, 4);
  Job job(std::move(x));
  job.sample.flattening.triangles.clear();
  EXPECT_TRUE(artifacts(job.finished(), Context()));
  EXPECT_EQ(report(job.finished())["thickness"]["chart_mean_ratio"], nullptr);
}

}  // namespace
}  // namespace vacuform
