#include "worker/forming/formed_sheet.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "tests/unit/fixtures/shapes.hpp"
#include "worker/forming/contact.hpp"
#include "worker/forming/sheet_grid.hpp"

namespace vacuform::forming_test {
namespace {

const TemperatureField warm(140);

TEST(Obstacles, TouchIsTheFirstPlaceOnTheWay) {
  const Mold mold = hemisphere(50);
  const Obstacles obstacles(mold.mesh, {});
  const auto top = obstacles.first_touch({0.3, 0.2, 60}, {0.3, 0.2, -10});
  ASSERT_TRUE(top);
  EXPECT_EQ(top->with, Contact::mold);
  EXPECT_NEAR(top->place.z(), 50, 0.01);
  EXPECT_NEAR(top->t, 10.0 / 70, 2e-4);
  const auto beside = obstacles.first_touch({80, 0, 5}, {80, 0, -5});
  ASSERT_TRUE(beside);
  EXPECT_EQ(beside->with, Contact::platform);
  EXPECT_EQ(beside->place.z(), 0);
  EXPECT_NEAR(beside->t, 0.5, 1e-12);
  const auto wall = obstacles.first_touch({-130, 20, 30}, {-150, 10, 30});
  ASSERT_TRUE(wall);
  EXPECT_EQ(wall->with, Contact::clamp);
  EXPECT_LT((wall->place - Eigen::Vector3d(-140, 15, 30)).norm(), 1e-12);
  MachineSettings round;
  round.window = WindowShape::circle;
  round.window_width_mm = 200;
  const auto ring = Obstacles(mold.mesh, round).first_touch({60, 70, 30}, {60, 90, 20});
  ASSERT_TRUE(ring);
  EXPECT_EQ(ring->with, Contact::clamp);
  EXPECT_LT((ring->place - Eigen::Vector3d(60, 80, 25)).norm(), 1e-12);
  EXPECT_FALSE(obstacles.first_touch({0, 0, 60}, {0, 0, 51}));
  EXPECT_FALSE(obstacles.first_touch({0, 0, 49}, {0, 0, 60}));  // leaving the mold is no touch
  EXPECT_FALSE(obstacles.first_touch({0, 0, 60}, {0, 0, 60}));
}

// A flat sheet at z = 10: motion from below is stopped, half way if the sheet moves as far; motion from above is not.
TEST(SheetAsObstacle, StopsWhatComesFromBelow) {
  Points x(3, 4);
  x << 0, 20, 20, 0, 0, 0, 20, 20, 10, 10, 10, 10;
  const std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  const SheetAsObstacle sheet(x, triangles);
  const auto stop = sheet.stops({5, 8, 4}, {5, 8, 12});
  ASSERT_TRUE(stop);
  EXPECT_NEAR(*stop, 0.375, 1e-6);  // 6 of 16 mm
  EXPECT_FALSE(sheet.stops({5, 8, 4}, {5, 8, 6.9}));
  EXPECT_FALSE(sheet.stops({5, 8, 12}, {5, 8, 4}));
  EXPECT_FALSE(SheetAsObstacle::possible(x, triangles, {0, 0, 0, 0}));
  x.col(3) << 30, 0, 5;  // the second triangle overhangs
  EXPECT_TRUE(SheetAsObstacle::possible(x, triangles, {0, 0, 0, 0}));
  EXPECT_FALSE(SheetAsObstacle::possible(x, triangles, {1, 1, 1, 1}));
}

// A mushroom: the sheet is drawn under the cap from all sides, and stays below the height where it was draped.
TEST(Forming, UndercutsDoNotLetTheSheetOut) {
  Mold mushroom = hemisphere(50);
  for (auto& p : mushroom.mesh.vertices) p.z() += 40;
  const int n = static_cast<int>(mushroom.mesh.vertices.size());
  for (int k = 0; k < 36; ++k) {  // the cap's lower side and a stem of radius 8
    const double a = k * std::numbers::pi / 18, b = (k + 1) * std::numbers::pi / 18;
    const auto ring = [](double r, double at, double z) {
      return Eigen::Vector3d(r * std::cos(at), r * std::sin(at), z);
    };
    for (const auto& p :
         {ring(50, a, 40), ring(50, b, 40), ring(8, a, 40), ring(8, b, 40), ring(8, a, 0), ring(8, b, 0)})
      mushroom.mesh.vertices.push_back(p);
    const int v = n + 6 * k;
    for (const Triangle& t :
         {Triangle{v, v + 2, v + 1}, {v + 1, v + 2, v + 3}, {v + 2, v + 4, v + 3}, {v + 3, v + 4, v + 5}})
      mushroom.mesh.triangles.push_back(t);
  }
  mushroom.top = {0, 0, 90};
  SheetSettings sheet;
  sheet.resolution_mm = 5;
  const auto formed = form(mushroom, sheet, {}, {}, warm, Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  int under_the_cap = 0;
  for (const auto& p : formed->formed) {
    EXPECT_LE(p.z(), 90);
    EXPECT_GE(p.z(), 0);
    under_the_cap += p.z() > 1 && p.z() < 39 && p.head<2>().norm() < 45;
  }
  EXPECT_GT(under_the_cap, 50);
  EXPECT_LT(formed->summary.mass_error, 1e-6);
}

SheetSettings coarse() {
  SheetSettings sheet;
  sheet.resolution_mm = 5;
  return sheet;
}

// Reference: a hemisphere of R = 85 mm under a ring of 1.5 R lowered to the platform, then vacuum.
TEST(Forming, HemisphereLandsWhereTheReferenceSays) {
  constexpr double R = 85;
  const Mold mold = hemisphere(R, 180, 360);
  MachineSettings machine;
  machine.window = WindowShape::circle;
  machine.window_width_mm = 3 * R;
  SheetSettings sheet;
  sheet.resolution_mm = 4;
  FormingSettings forming;
  forming.law = MembraneLaw::neo_hookean;
  const auto formed = form(mold, sheet, machine, forming, warm, Context{});
  ASSERT_TRUE(formed) << formed.error().text();

  const std::array<std::array<double, 3>, 6> reference{{{15, .2594, .974},
                                                        {30, .5032, .885},
                                                        {45, .7132, .719},
                                                        {60, .8913, .698},
                                                        {75, 1.0618, .668},
                                                        {85, 1.1586, .560}}};
  const auto polar = [&](int v) {
    const auto& p = formed->formed[v];
    return std::atan2(std::hypot(p.x(), p.y()), p.z()) * 180 / std::numbers::pi;
  };
  for (const auto& [angle, radius, thickness] : reference) {
    double sum_radius = 0, sum_thickness = 0;
    int crossings = 0;
    for (const Triangle& t : formed->triangles)
      for (int e = 0; e < 3; ++e) {
        const int a = t[e], b = t[(e + 1) % 3];
        const double pa = polar(a) - angle, pb = polar(b) - angle;
        if (formed->contact[a] != Contact::mold || formed->contact[b] != Contact::mold || pa * pb >= 0)
          continue;
        const double w = pa / (pa - pb);
        const double landed = (1 - w) * formed->rest[a].norm() + w * formed->rest[b].norm();
        EXPECT_NEAR(landed, radius * R, 0.5) << angle << " degrees";
        sum_radius += landed;
        sum_thickness += (1 - w) * formed->thickness[a] + w * formed->thickness[b];
        ++crossings;
      }
    ASSERT_GT(crossings, 20) << angle << " degrees";
    EXPECT_NEAR(sum_radius / crossings, radius * R, 0.25) << angle << " degrees";
    EXPECT_NEAR(sum_thickness / crossings, thickness, (angle < 80 ? 0.02 : 0.04) * thickness)
        << angle << " degrees";
  }

  const FormingSummary& s = formed->summary;
  EXPECT_TRUE(s.converged);
  EXPECT_LT(s.residual, 1e-3);
  EXPECT_LT(s.mass_error, 1e-9);
  EXPECT_LT(s.force_error, 1e-4);
  EXPECT_NEAR(s.pressure_kpa, 85, 1e-9);

  // The vertices marked as touching do touch, and the thicknesses at the vertices add up to all the plastic.
  double plastic = 0;
  for (std::size_t i = 0; i < formed->formed.size(); ++i) {
    const auto& p = formed->formed[i];
    if (formed->contact[i] == Contact::mold) {
      EXPECT_NEAR(p.norm(), R, 0.02);
    } else if (formed->contact[i] == Contact::platform) {
      EXPECT_EQ(p.z(), 0);
    }
    EXPECT_GE(p.z(), 0);
  }
  for (const Triangle& t : formed->triangles) {
    const double area = 0.5 * (formed->formed[t[1]] - formed->formed[t[0]])
                                  .cross(formed->formed[t[2]] - formed->formed[t[0]])
                                  .norm();
    plastic += area * (formed->thickness[t[0]] + formed->thickness[t[1]] + formed->thickness[t[2]]) / 3;
  }
  EXPECT_NEAR(plastic / 90000, 1, 1e-9);
}

TEST(Forming, SameInputSameBytes) {
  const Mold mold = hemisphere(60);
  const auto a = form(mold, coarse(), {}, {}, warm, Context{}),
             b = form(mold, coarse(), {}, {}, warm, Context{});
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->formed.size(), b->formed.size());
  EXPECT_EQ(std::memcmp(a->formed.data(), b->formed.data(), a->formed.size() * sizeof(Eigen::Vector3d)), 0);
}

// A square window over a round mold: the result has the symmetry of both.
TEST(Forming, KeepsTheSymmetryOfMoldAndFrame) {
  const auto formed = form(hemisphere(60), coarse(), {}, {}, warm, Context{});
  ASSERT_TRUE(formed);
  for (std::size_t i = 0; i < formed->rest.size(); ++i)
    for (std::size_t j = 0; j < formed->rest.size(); ++j)
      if ((formed->rest[i] + formed->rest[j]).norm() < 1e-9) {
        const Eigen::Vector3d turned(-formed->formed[j].x(), -formed->formed[j].y(), formed->formed[j].z());
        EXPECT_LT((formed->formed[i] - turned).norm(), 0.1);
      }
}

// A frame that stops above the mold touches nothing until the vacuum; the sheet is still drawn down.
TEST(Forming, DrapeHeightAboveTheMoldStillForms) {
  MachineSettings machine;
  machine.drape_height_mm = 70;
  const auto formed = form(hemisphere(60), coarse(), machine, {}, warm, Context{});
  ASSERT_TRUE(formed) << formed.error().text();
  EXPECT_EQ(formed->summary.drape_steps, 0);
  int on_mold = 0;
  for (std::size_t i = 0; i < formed->contact.size(); ++i)
    if (formed->contact[i] == Contact::mold) {
      ++on_mold;
      EXPECT_GE(formed->contact_time[i], 1);
    }
  EXPECT_GT(on_mold, 300);
}

TEST(Forming, CancelEndsWithinASecond) {
  Context context;
  std::thread canceller([context]() mutable {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    context.cancel();
  });
  SheetSettings sheet;
  sheet.resolution_mm = 1;
  const auto begin = std::chrono::steady_clock::now();
  const auto formed = form(hemisphere(60), sheet, {}, {}, warm, context);
  const auto took = std::chrono::steady_clock::now() - begin;
  canceller.join();
  ASSERT_FALSE(formed);
  EXPECT_EQ(formed.error().code, Code::cancelled);
  EXPECT_LT(took, std::chrono::milliseconds(300) + std::chrono::seconds(2));
}

// With stick, a uniform viscosity changes the time scale and not the map; the sheet flows where the elastic one
// stretches.
TEST(Forming, AViscousSheetLandsAtAnyUniformViscosity) {
  FormingSettings viscous;
  viscous.model = FormingModel::viscoplastic;
  SheetSettings sheet = coarse();
  sheet.resolution_mm = 8;
  MachineSettings slow;
  slow.vacuum_seconds = 600;
  slow.drape_speed_mm_s = 5;
  const Mold mold = hemisphere(60);
  const auto warm_one = form(mold, sheet, slow, viscous, TemperatureField(140), Context{});
  const auto hot_one = form(mold, sheet, slow, viscous, TemperatureField(150), Context{});
  ASSERT_TRUE(warm_one) << warm_one.error().text();
  ASSERT_TRUE(hot_one) << hot_one.error().text();
  double furthest = 0;
  for (std::size_t i = 0; i < make_sheet_grid(sheet, slow).rest.size(); ++i)
    if (warm_one->contact[i] == Contact::mold)
      furthest = std::max(furthest, (warm_one->formed[i] - hot_one->formed[i]).norm());
  EXPECT_LT(furthest, 0.6);
  EXPECT_LT(warm_one->summary.mass_error, 1e-6);
  EXPECT_LT(warm_one->summary.force_error, 1e-3);
}

// Below its yield stress the sheet equals the elastic one.
TEST(Forming, AHighYieldStressLeavesTheSheetElastic) {
  FormingSettings firm;
  firm.model = FormingModel::viscoplastic;
  firm.yield_kpa = 1000;
  SheetSettings sheet = coarse();
  sheet.resolution_mm = 8;
  MachineSettings gentle;
  gentle.vacuum_kpa = 20;
  const Mold mold = hemisphere(60);
  const auto held = form(mold, sheet, gentle, firm, warm, Context{});
  const auto elastic = form(mold, sheet, gentle, {}, warm, Context{});
  ASSERT_TRUE(held) << held.error().text();
  ASSERT_TRUE(elastic) << elastic.error().text();
  double furthest = 0;
  for (std::size_t i = 0; i < make_sheet_grid(sheet, gentle).rest.size(); ++i)
    furthest = std::max(furthest, (held->formed[i] - elastic->formed[i]).norm());
  EXPECT_LT(furthest, 0.5);
}

// While the sag is shallow, the weight of the sheet acts like a pressure of density x gravity x thickness.
TEST(Forming, AHotSheetSagsAndTheFrameStartsHigher) {
  FormingSettings heavy;
  heavy.sag = true;
  const Mold mold = hemisphere(60);
  const auto sagged = form(mold, coarse(), {}, heavy, warm, Context{});
  const auto weightless = form(mold, coarse(), {}, {}, warm, Context{});
  ASSERT_TRUE(sagged) << sagged.error().text();
  ASSERT_TRUE(weightless) << weightless.error().text();
  EXPECT_GT(sagged->summary.drape_steps, weightless->summary.drape_steps);
  EXPECT_LT(sagged->summary.force_error, 1e-3);
  EXPECT_LT(sagged->summary.residual, 1e-3);
}

}  // namespace
}  // namespace vacuform::forming_test
