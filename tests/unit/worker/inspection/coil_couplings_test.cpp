// What the report, the summary and the warnings say of coupling, and what a coil keeps on the head.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/fixtures/coils_shapes.hpp"
#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/coil_json.hpp"
#include "worker/inspection/coil_warnings.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/inspection/report_sections.hpp"
#include "worker/inspection/summary.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform::coil_couplings_test {
namespace {

using Eigen::Vector2d;
using hand_made::Sample;

// The drawing printed as it is on a sheet that stays flat.
CoilTable measured_flat(const Drawing& drawing) {
  const Sample x = hand_made::flat(260, 60);
  const Placement placement;
  const auto loops = coil_loops(drawing, placement, VectorPrint(), x.flattening, Alignment());
  return *measure_coils({MeasuredSheet(hand_made::Charted(x))}, loops, neighbours(loops, placement, drawing),
                        {}, Context());
}

TEST(CoilCouplings, NameTheWorstOfAllPairsAndOfTheNeighboursInACriticalHexagon) {
  const CoilTable table = measured_flat(hand_made::seven_rings(20, 1.51604 * 20));
  EXPECT_EQ(table.pairs.size(), 12u);
  const CoilSummary& flat = table.without;
  ASSERT_TRUE(flat.strongest_neighbours && flat.strongest);
  EXPECT_LT(std::abs(flat.strongest_neighbours->k), 0.002);
  EXPECT_NEAR(flat.strongest->k, -0.02, 0.001);
  EXPECT_NEAR(flat.strongest->mm, std::sqrt(3) * 1.51604 * 20, 0.05);
  EXPECT_GT(flat.strongest->a, 0);
  const auto json = summary_json(table, Way::without);
  EXPECT_NEAR(json["worst_k"].get<double>(), std::abs(flat.strongest_neighbours->k), 1e-5);
  EXPECT_EQ(json["strongest_pair"]["coils"][0], table.coils[static_cast<std::size_t>(flat.strongest->a)].id);
  EXPECT_NEAR(json["strongest_pair"]["k"].get<double>(), flat.strongest->k, 1e-5);
}

TEST(CoilCouplings, AreReportedAsAFullMatrixOfTheCoilsOnTheHead) {
  CoilTable table = measured_flat(hand_made::seven_rings(20, 1.51604 * 20));
  EXPECT_EQ(couplings_json(table), nullptr);  // nothing is printed
  for (Coil& coil : table.coils) coil.with = coil.without;
  table.k.with = table.k.without;
  table.coils[3].with->on_head = false;
  const auto json = couplings_json(table);
  EXPECT_EQ(json["coils"].dump(), R"(["coil-0","coil-1","coil-2","coil-4","coil-5","coil-6"])");
  ASSERT_EQ(json["k"].size(), 6u);
  for (std::size_t a = 0; a < 6; ++a) {
    EXPECT_EQ(json["k"][a].size(), 6u);
    EXPECT_EQ(json["k"][a][a], 1);
  }
  EXPECT_NEAR(json["k"][1][5].get<double>(), 0, 0.002);      // coil-1 and coil-6 are neighbours
  EXPECT_NEAR(json["k"][1][4].get<double>(), -0.02, 0.001);  // coil-1 and coil-5 are not
  EXPECT_EQ(json["k"][1][4], json["k"][4][1]);
}

ReportJson coupled_report(bool same_pair) {
  const ReportJson near{{"coils", {"coil-1", "coil-2"}}, {"distance_mm", 30.321}, {"k", 0.00431}};
  const ReportJson far{{"coils", {"coil-2", "coil-6"}}, {"distance_mm", 52.5}, {"k", -0.019}};
  ReportJson report;
  report["figures"]["with"]["coils"] = {{"strongest_neighbours", near},
                                        {"strongest_pair", same_pair ? near : far}};
  return report;
}

TEST(CoilCouplings, AreSaidInWordsWithWhatGeometryAllows) {
  EXPECT_EQ(
      coupling_text(coupled_report(false)),
      "Strongest coupling of neighbours: coil-1 and coil-2, k = 0.0043 at 30.32 mm. Strongest of any two "
      "coils: coil-2 and coil-6, k = -0.0190 at 52.50 mm.");
  EXPECT_NE(what_geometry_allows(coupled_report(false)).find("cannot be cancelled at the same time"),
            std::string::npos);
  EXPECT_EQ(coupling_text(coupled_report(true)),
            "Strongest coupling of neighbours: coil-1 and coil-2, k = 0.0043 at 30.32 mm. No other two coils "
            "couple more.");
  EXPECT_EQ(what_geometry_allows(coupled_report(true)), "");
  EXPECT_EQ(coupling_text(ReportJson::object()), "");
  const std::string summary = summary_text(coupled_report(false), "out");
  EXPECT_NE(summary.find("coil-2 and coil-6, k = -0.0190 at 52.50 mm.\nOverlap cancels"), std::string::npos)
      << summary;
}

Coil coil_at(const std::string& id, double x, bool on_head = true) {
  Coil out;
  out.id = id;
  out.drawn_diameter_mm = 40;
  out.with.emplace();
  out.with->on_head = on_head;
  out.with->centre = {x, 0, 0};
  return out;
}

CoilTable coupled_table() {
  CoilTable table;
  table.coils = {coil_at("a", 0), coil_at("b", 30), coil_at("c", 60), coil_at("off", 90, false)};
  for (const auto& [a, b, k] : {std::tuple{0, 1, -0.012}, {1, 2, 0.03}, {0, 2, 0.0099}, {2, 3, 0.5}}) {
    CoilPair& pair = table.pairs.emplace_back();
    pair.a = a, pair.b = b;
    pair.with = PairFigures{30, 10, k};
  }
  table.with.pairs = 3;
  return table;
}

TEST(CoilWarnings, NameCoupledNeighboursOnTheHeadStrongestFirst) {
  const auto warnings = coil_warnings(coupled_table(), true);
  ASSERT_EQ(warnings.size(), 1u);
  const Warning& coupled = warnings[0];
  EXPECT_EQ(coupled.code, "coils-coupled");
  EXPECT_EQ(coupled.text,
            "2 of 3 pairs of neighbours on the head couple by 0.01 or more: the surface does not let them be "
            "decoupled within coils.size_limit; the strongest, b and c, by k = 0.030");
  EXPECT_EQ(coupled.place, "b and c (k = 0.030), a and b (k = -0.012)");
  EXPECT_EQ(coupled.figure->value, 0.03);
  EXPECT_EQ(*coupled.figure->limit, 0.01);
  ASSERT_EQ(coupled.marks.size(), 2u);
  EXPECT_EQ(coupled.marks[0].place_mm[0], 45);
  EXPECT_EQ(coupled.what_to_do(), warning_kind("coils-coupled").fix);
}

TEST(CoilWarnings, SayThatCoupledNeighboursWereNotDecoupled) {
  CoilTable table = coupled_table();
  const auto warnings = coil_warnings(table, false);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].text.find("size_limit"), std::string::npos);
  EXPECT_TRUE(warnings[0].fix.starts_with("Set coils.decouple=true")) << warnings[0].fix;
  table.pairs.resize(1);
  table.pairs[0].with->k = 0.0099;
  EXPECT_TRUE(coil_warnings(table, false).empty());
}

// The loop of a drawing's only element as its placement prints it.
LoopFigures placed_loop(const Element& element, CoilKeep keep) {
  const Sample x = hand_made::sphere(85, 160, 160);
  Drawing drawing;
  drawing.elements = {element};
  Settings settings;
  settings.coils.keep = keep;
  const auto placed = place(hand_made::Charted(x), &drawing, settings, Context());
  EXPECT_TRUE(placed);
  const Patch& patch = placed->elements[0].patch;
  const PlaneLocator locator(patch.triangles, patch.uv);
  std::vector<Vector2d> line;
  const auto& points = element.shapes[0].curves[0].points;
  for (std::size_t s = 0; s + 3 < points.size(); s += 3)
    for (int i = 0; i < 60; ++i) {
      const double t = i / 60.0, u = 1 - t;
      const Vector2d uv = u * u * u * points[s] + 3 * u * u * t * points[s + 1] +
                          3 * u * t * t * points[s + 2] + t * t * t * points[s + 3];
      const auto found = locator.find(uv);
      EXPECT_TRUE(found);
      line.push_back(interpolate(patch.triangles, *found, patch.rest));
    }
  const auto loop =
      measure_loop(MeasuredSheet(hand_made::Charted(x)), line, placed->elements[0].centre_rest, keep);
  EXPECT_TRUE(loop);
  return *loop;
}

TEST(CoilsKeep, TheAreaOfACircleOnASphere) {
  const LoopFigures loop = placed_loop(hand_made::ring("coil", {0, 0}, 40), CoilKeep::area);
  EXPECT_NEAR(loop.diameter_mm, 80.76, 0.05);
  EXPECT_NEAR(loop.area_mm2 / (M_PI * 40 * 40), 1, 0.001);
  EXPECT_LT(loop.circularity, 0.002);
}

TEST(CoilsKeep, TheDiameterOfACircleOnASphere) {
  const LoopFigures loop = placed_loop(hand_made::ring("coil", {0, 0}, 40), CoilKeep::diameter);
  EXPECT_NEAR(loop.diameter_mm, 80.00, 0.05);
  // Of the cap whose edge lies 40 mm from its pole along the sphere.
  EXPECT_NEAR(loop.area_mm2 / (2 * M_PI * 85 * 85 * (1 - std::cos(40.0 / 85))), 1, 0.001);
  EXPECT_LT(loop.circularity, 0.002);
  for (const Vector2d& p : loop.shape) EXPECT_NEAR(p.norm(), 40, 0.05);  // judged by its distances
}

Element rectangle(double width, double height) {
  Element out = hand_made::ring("coil", {0, 0}, 1);
  Curve& curve = out.shapes[0].curves[0];
  const std::array<Vector2d, 5> corners{Vector2d(width, height) / 2, Vector2d(-width, height) / 2,
                                        Vector2d(-width, -height) / 2, Vector2d(width, -height) / 2,
                                        Vector2d(width, height) / 2};
  curve.points = {corners[0]};
  for (std::size_t i = 0; i < 4; ++i)
    for (int k = 1; k <= 3; ++k) curve.points.push_back(corners[i] + k / 3.0 * (corners[i + 1] - corners[i]));
  return out;
}

TEST(CoilsKeep, LengthsAcrossThroughTheCentreOfOtherShapes) {
  const LoopFigures loop = placed_loop(rectangle(80, 50), CoilKeep::diameter);
  double least = 1e9, most = 0;
  for (const Vector2d& p : loop.shape) least = std::min(least, p.norm()), most = std::max(most, p.norm());
  EXPECT_NEAR(least, 25, 0.06);                 // to the middle of a long side
  EXPECT_NEAR(most, std::hypot(40, 25), 0.06);  // to a corner
}

TEST(CaptionWords, CountTheCoilsOnTheHeadAndHowFarTheyAreOff) {
  CoilTable table;
  table.coils.resize(19);
  CoilSummary& with = table.with;
  EXPECT_EQ(coils_caption(table, Way::with), "0 of 19 coils on the head");
  with.coils = with.round = 6;
  with.mean_circularity = 0.0012, with.worst_circularity = 0.0034, with.mean_area_error = 0.0005;
  with.mean_shape_error = 0.02, with.worst_shape_error = 0.03;
  EXPECT_EQ(coils_caption(table, Way::with),
            "6 of 19 coils on the head: out of round by 0.12 % on average, 0.34 % at worst     area off by "
            "0.05 % on average");
  with.round = 5;  // one is no circle
  EXPECT_EQ(
      coils_caption(table, Way::with),
      "6 of 19 coils on the head: off their drawn shape by 2.00 % on average, 3.00 % at worst     area off "
      "by 0.05 % on average");
  EXPECT_EQ(coils_caption(table, Way::without), "0 of 19 coils on the head");
  table.coils.resize(1);
  with = {};
  EXPECT_EQ(coils_caption(table, Way::with), "0 of 1 coil on the head");
}

TEST(CaptionWords, SayWhereTheInkGoes) {
  EXPECT_EQ(ink_caption(1, 1), "All of the drawing's ink lies on the head.");
  EXPECT_EQ(ink_caption(1, 0.412),
            "All of the drawing's ink is printed; 41.2 % of it lies on the head, the rest beside it.");
  EXPECT_EQ(
      ink_caption(0.75, 0.5),
      "25.0 % of the drawing's ink lies off the formed part and is not printed; 50.0 % lies on the head.");
  EXPECT_EQ(ink_caption(0.9996, 0.9996), "All of the drawing's ink lies on the head.");
}

}  // namespace
}  // namespace vacuform::coil_couplings_test
