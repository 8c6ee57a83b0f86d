// The colours of a sphere on a sheet that lies on it: a dome of radius 60 mm (hand_made_sheets.hpp), whose colours are known
// at every place.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/unit/fixtures/coloured_scans.hpp"
#include "tests/unit/fixtures/hand_made_sheets.hpp"
#include "worker/colour/colour_difference.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/printing/colour_raster.hpp"

namespace vacuform {
namespace {

using coloured::Model;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using shapes::FileBytes;

constexpr double pi = std::numbers::pi, sphere_mm = 60, on_dome_mm = 67, pixel_mm = 0.2;

struct Printed {
  int side = 0;
  std::vector<std::uint8_t> rgba;

  const std::uint8_t* at(int x, int y) const {
    return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(side) +
                      static_cast<std::size_t>(x))];
  }
  Vector3f linear(int x, int y) const {
    const std::uint8_t* p = at(x, y);
    return {linear_from_srgb(static_cast<float>(p[0]) / 255),
            linear_from_srgb(static_cast<float>(p[1]) / 255),
            linear_from_srgb(static_cast<float>(p[2]) / 255)};
  }
  Vector2d rest(int x, int y) const {
    return {(x + 0.5 - side / 2.0) * pixel_mm, (side / 2.0 - y - 0.5) * pixel_mm};
  }
  // Between pixels.
  Vector3f linear(const Vector2d& rest) const {
    const double x = rest.x() / pixel_mm + side / 2.0 - 0.5, y = side / 2.0 - rest.y() / pixel_mm - 0.5;
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    const float fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
    return (1 - fy) * ((1 - fx) * linear(i, j) + fx * linear(i + 1, j)) +
           fy * ((1 - fx) * linear(i, j + 1) + fx * linear(i + 1, j + 1));
  }
};

Printed printed(const FormedSheet& sheet, const FileBytes& scan, const std::string& name,
                double fade_mm = 3) {
  const auto coloured = read_coloured_scan(scan, name, Context());
  EXPECT_TRUE(coloured) << coloured.error().text();
  const SheetColours colours(ColouredSurface(*coloured, {}), sheet, colour_reach(0, fade_mm));
  Printed out;
  out.side = 1500;
  const ColourRaster raster(colours, {out.side, out.side, pixel_mm});
  for (int top = 0; top < out.side; top += raster.band_rows()) {
    const auto rows = raster.rows(top, std::min(top + raster.band_rows(), out.side));
    out.rgba.insert(out.rgba.end(), rows.begin(), rows.end());
  }
  return out;
}

const FormedSheet& dome_sheet() {
  static const FormedSheet sheet = hand_made::dome(150).sheet;
  return sheet;
}

struct OnSphere {
  double along, down;  // of sphere(): u 2 pi and v pi
};
OnSphere on_sphere(const Vector3d& p) {
  const double along = std::atan2(p.y(), p.x());
  return {along < 0 ? along + 2 * pi : along, std::acos(p.z() / p.norm())};
}

// The share of [from, to] on which a wave of this period is high.
double share_high(double from, double to, double period) {
  const auto sum = [&](double x) {
    return std::floor(x / period) * period / 2 + std::min(std::fmod(x, period), period / 2);
  };
  return (sum(to) - sum(from)) / (to - from);
}

// Ten degrees of light, ten of dark.
constexpr double band = 20 * pi / 180;

TEST(ColouredSheet, HasEveryLatitudeInItsPlace) {
  constexpr int height = 1024;
  const auto image = coloured::png(2, height, [](double, double v) {
    const double half = 0.5 / height;
    return Vector3f::Constant(static_cast<float>(share_high(pi * (v - half), pi * (v + half), band))).eval();
  });
  const Printed print =
      printed(dome_sheet(), coloured::glb(coloured::sphere(sphere_mm, 240), image), "a.glb");
  const SheetMap map(dome_sheet());
  std::vector<double> errors;
  for (int k = 0; k < 90; ++k) {
    const Vector2d along(std::cos(pi * k / 45), std::sin(pi * k / 45));
    constexpr double step = 0.05;
    for (double r = 2; r < on_dome_mm; r += step) {
      const float a = print.linear(r * along).x() - 0.5f, b = print.linear((r + step) * along).x() - 0.5f;
      if ((a > 0) == (b > 0)) continue;
      const double down = on_sphere(*map((r + step * a / (a - b)) * along)).down;
      errors.push_back(sphere_mm * std::abs(down - std::round(down / (band / 2)) * (band / 2)));
    }
  }
  EXPECT_EQ(errors.size(), 90u * 7);  // at 10, 20 ... 70 degrees
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 99 / 100], 0.2);
  RecordProperty("p99_um", static_cast<int>(1000 * errors[errors.size() * 99 / 100]));
}

TEST(ColouredSheet, HasEveryLongitudeInItsPlace) {
  constexpr int width = 2048;
  const auto image = coloured::png(width, 2, [](double u, double) {
    const double half = 0.5 / width;
    return Vector3f::Constant(static_cast<float>(share_high(2 * pi * (u - half), 2 * pi * (u + half), band)))
        .eval();
  });
  const Printed print =
      printed(dome_sheet(), coloured::glb(coloured::sphere(sphere_mm, 240), image), "a.glb");
  const SheetMap map(dome_sheet());
  std::vector<double> errors;
  for (double r = 20; r < on_dome_mm; r += 1.3) {
    constexpr double step = 0.0005;
    const auto place = [&](double angle) { return Vector2d(r * std::cos(angle), r * std::sin(angle)); };
    for (double angle = 0.05; angle < 2 * pi - 0.05; angle += step) {
      const float a = print.linear(place(angle)).x() - 0.5f, b = print.linear(place(angle + step)).x() - 0.5f;
      if ((a > 0) == (b > 0)) continue;
      const OnSphere at = on_sphere(*map(place(angle + step * a / (a - b))));
      errors.push_back(sphere_mm * std::sin(at.down) *
                       std::abs(at.along - std::round(at.along / (band / 2)) * (band / 2)));
    }
  }
  EXPECT_EQ(errors.size(), 37u * 35);  // rings, and 10, 20 ... 350 degrees
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 99 / 100], 0.2);
  RecordProperty("p99_um", static_cast<int>(1000 * errors[errors.size() * 99 / 100]));
}

// Smooth and colourful all around.
Vector3f smooth(double along, double down) {
  return {static_cast<float>(0.5 + 0.4 * std::sin(3 * along)),
          static_cast<float>(0.5 + 0.4 * std::cos(2 * along + 4 * down)),
          static_cast<float>(0.5 + 0.4 * std::sin(5 * down))};
}

struct Difference {
  double mean = 0, largest = 0;
};
Difference difference_from_smooth(const Printed& print) {
  const SheetMap map(dome_sheet());
  Difference out;
  int count = 0;
  for (int y = 0; y < print.side; y += 3)
    for (int x = 0; x < print.side; x += 3) {
      const Vector2d rest = print.rest(x, y);
      if (rest.norm() > on_dome_mm || rest.norm() < 6)
        continue;  // at the pole the longitude changes within a pixel
      const OnSphere at = on_sphere(*map(rest));
      const double d = ciede2000(lab_of(print.linear(x, y)), lab_of(smooth(at.along, at.down)));
      out.mean += d;
      out.largest = std::max(out.largest, d);
      ++count;
    }
  out.mean /= count;
  return out;
}

FileBytes smooth_glb() {
  const auto image = coloured::png(1024, 512, [](double u, double v) { return smooth(2 * pi * u, pi * v); });
  return coloured::glb(coloured::sphere(sphere_mm, 240), image);
}

TEST(ColouredSheet, HasTheColoursOfTheModel) {
  const Difference d = difference_from_smooth(printed(dome_sheet(), smooth_glb(), "a.glb"));
  EXPECT_LT(d.mean, 1);
  EXPECT_LT(d.largest, 2);
  RecordProperty("mean_milli", static_cast<int>(1000 * d.mean));
  RecordProperty("largest_milli", static_cast<int>(1000 * d.largest));
}

// Six sectors of the sphere, each with one of the two points of a palette.
TEST(ColouredSheet, BordersOfColoursAreSmooth) {
  constexpr int sectors = 6;
  Model model = coloured::sphere(sphere_mm, 240);
  for (std::size_t i = 0; i < model.uv.size(); i += 3) {
    const double along = (model.uv[i] + model.uv[i + 1] + model.uv[i + 2]).x() / 3;
    for (std::size_t k = i; k < i + 3; ++k)
      model.uv[k] = {static_cast<int>(sectors * along) % 2 == 0 ? 0.25 : 0.75, 0.5};
  }
  const auto palette = coloured::png(
      2, 1, [](double u, double) -> Vector3f { return u < 0.5 ? Vector3f(1, 0, 0) : Vector3f(0, 0, 1); });
  const Printed print = printed(dome_sheet(), coloured::glb(model, palette), "a.glb");
  int mixed = 0, far_from_border = 0;
  for (int y = 0; y < print.side; ++y)
    for (int x = 0; x < print.side; ++x) {
      const Vector2d rest = print.rest(x, y);
      if (rest.norm() < 10 || rest.norm() > on_dome_mm) continue;
      const Vector3f colour = print.linear(x, y);
      if (colour.x() * colour.z() < 0.05f) continue;
      ++mixed;
      const double along = std::atan2(rest.y(), rest.x()), border = 2 * pi / sectors;
      const double off = rest.norm() * std::abs(along - border * std::round(along / border));
      far_from_border += off > 1.5 * pixel_mm ? 1 : 0;
    }
  // Four of the borders cross about a thousand rows of pixels; the other two lie between two rows.
  EXPECT_GT(mixed, 500);
  EXPECT_EQ(far_from_border, 0);
}

// Ten by five patches of the sphere, each in a separate cell of the image in another order, and black between them.
TEST(ColouredSheet, ShowsNoSeamBetweenFiftyIslands) {
  constexpr int columns = 10, rows = 5;
  constexpr double margin = 0.08;
  Model model = coloured::sphere(sphere_mm, 240);
  for (std::size_t i = 0; i < model.uv.size(); i += 3) {
    const Vector2d middle = (model.uv[i] + model.uv[i + 1] + model.uv[i + 2]) / 3;
    const int column = static_cast<int>(columns * middle.x()), row = static_cast<int>(rows * middle.y());
    const int cell = (7 * (row * columns + column) + 3) % (columns * rows);
    for (std::size_t k = i; k < i + 3; ++k) {
      const Vector2d within(columns * model.uv[k].x() - column, rows * model.uv[k].y() - row);
      model.uv[k] = {(cell % columns + margin + (1 - 2 * margin) * within.x()) / columns,
                     (static_cast<double>(cell / columns) + margin + (1 - 2 * margin) * within.y()) / rows};
    }
  }
  constexpr int width = 1200, height = 600;
  const auto atlas = coloured::png(width, height, [&](double u, double v) -> Vector3f {
    const int at_column = static_cast<int>(columns * u), at_row = static_cast<int>(rows * v);
    const int cell = at_row * columns + at_column;
    int home = 0;
    while ((7 * home + 3) % (columns * rows) != cell) ++home;
    const Vector2d within((columns * u - at_column - margin) / (1 - 2 * margin),
                          (rows * v - at_row - margin) / (1 - 2 * margin));
    if (within.minCoeff() < 0 || within.maxCoeff() > 1) return Vector3f::Zero();
    return smooth(2 * pi * (home % columns + within.x()) / columns,
                  pi * (static_cast<double>(home / columns) + within.y()) / rows);
  });
  const Printed print = printed(dome_sheet(), coloured::glb(model, atlas), "a.glb");
  const Difference d = difference_from_smooth(print);
  EXPECT_LT(d.mean, 1);
  EXPECT_LT(d.largest, 3);
  RecordProperty("largest_milli", static_cast<int>(1000 * d.largest));

  // From one pixel to the next in another island, beside the same step on the model with the levels of a pixel.
  const SheetMap map(dome_sheet());
  const auto placed = [&](int x, int y) -> std::optional<OnSphere> {
    const double r = print.rest(x, y).norm();
    if (r > on_dome_mm || r < 6) return std::nullopt;
    return on_sphere(*map(print.rest(x, y)));
  };
  const auto island = [&](const OnSphere& at) {
    return static_cast<int>(rows * at.down / pi) * columns + static_cast<int>(columns * at.along / (2 * pi));
  };
  const auto in_levels = [](const OnSphere& at) {
    return smooth(at.along, at.down)
        .unaryExpr([](float x) { return linear_from_srgb(std::round(255 * srgb_from_linear(x)) / 255); })
        .eval();
  };
  double on_print = 0, on_model = 0;
  int steps = 0;
  for (int y = 0; y < print.side; ++y)
    for (int x = 0; x < print.side; ++x) {
      const auto here = placed(x, y);
      if (!here) continue;
      for (const auto& [i, j] : {std::pair(x + 1, y), std::pair(x, y + 1)}) {
        const auto there = placed(i, j);
        if (!there || island(*here) == island(*there)) continue;
        on_print = std::max(on_print, ciede2000(lab_of(print.linear(x, y)), lab_of(print.linear(i, j))));
        on_model = std::max(on_model, ciede2000(lab_of(in_levels(*here)), lab_of(in_levels(*there))));
        ++steps;
      }
    }
  EXPECT_GT(steps, 3000);
  // Half a level of the texture and half a level of the print on each side.
  constexpr double of_levels = 0.3;
  EXPECT_LE(on_print, on_model + of_levels);
  RecordProperty("jump_milli", static_cast<int>(1000 * on_print));
  RecordProperty("jump_on_model_milli", static_cast<int>(1000 * on_model));
}

TEST(ColouredSheet, IsTheSameFromEveryFormat) {
  Model model = coloured::sphere(sphere_mm, 160);
  for (const Vector3d& p : model.places) {
    const OnSphere at = on_sphere(p);
    model.colours.push_back(smooth(at.along, at.down));
  }
  model.uv.clear();
  const Printed of_glb = printed(dome_sheet(), coloured::glb(model, {}), "a.glb");
  for (const auto& [name, bytes] :
       {std::pair<std::string, FileBytes>{"a.ply", coloured::ply(model)}, {"a.obj", coloured::obj(model)}}) {
    const Printed other = printed(dome_sheet(), bytes, name);
    int largest = 0;
    for (std::size_t i = 0; i < of_glb.rgba.size(); ++i)
      largest = std::max(largest, std::abs(of_glb.rgba[i] - other.rgba[i]));
    EXPECT_LE(largest, 1) << name;
  }
}

TEST(ColouredSheet, IsTheSameFromEveryFormatWithATexture) {
  const auto image = coloured::png(1024, 512, [](double u, double v) { return smooth(2 * pi * u, pi * v); });
  const Model model = coloured::sphere(sphere_mm, 160);
  const Printed of_glb = printed(dome_sheet(), coloured::glb(model, image), "a.glb");
  for (const auto& [name, bytes] :
       {std::pair<std::string, FileBytes>{"OBJ", coloured::obj_zip(model, image)},
        {"PLY with coordinates of corners", coloured::ply_zip(model, image, true)},
        {"PLY with coordinates of vertices", coloured::ply_zip(model, image, false)}}) {
    const Printed other = printed(dome_sheet(), bytes, "a.zip");
    int largest = 0;
    for (std::size_t i = 0; i < of_glb.rgba.size(); ++i)
      largest = std::max(largest, std::abs(of_glb.rgba[i] - other.rgba[i]));
    EXPECT_LE(largest, 1) << name;
  }
}

TEST(ColouredSheet, FadesWhereTheSheetLeavesTheScan) {
  const Printed print = printed(dome_sheet(), smooth_glb(), "a.glb"),
                none = printed(dome_sheet(), smooth_glb(), "a.glb", 0);
  const auto opacity = [](const Printed& of, double r) {
    return of.at(of.side / 2 + static_cast<int>(r / pixel_mm), of.side / 2)[3];
  };
  EXPECT_EQ(opacity(print, 60), 255);
  EXPECT_EQ(opacity(print, 140), 0);
  int faded = 0, faded_without = 0;
  for (double r = 60; r < 140; r += pixel_mm) {
    EXPECT_LE(opacity(print, r + pixel_mm), opacity(print, r)) << r;
    faded += opacity(print, r) > 20 && opacity(print, r) < 235;
    faded_without += opacity(none, r) > 20 && opacity(none, r) < 235;
  }
  EXPECT_GE(faded, 5);
  EXPECT_LE(faded_without, 1);
}

TEST(ColouredSheet, ListsWhatItDoesNotShow) {
  constexpr double inner_mm = 30;
  Model model = coloured::sphere(sphere_mm, 160);
  const auto hidden_of = [](const Model& of) {
    const auto image = coloured::png(8, 8, [](double u, double v) { return smooth(2 * pi * u, pi * v); });
    const auto coloured = read_coloured_scan(coloured::glb(of, image), "a.glb", Context());
    EXPECT_TRUE(coloured) << coloured.error().text();
    return SheetColours(ColouredSurface(*coloured, {}), dome_sheet(), colour_reach(0, 3)).hidden();
  };
  const HiddenSurface alone = hidden_of(model);
  EXPECT_NEAR(alone.whole_mm2, 2 * pi * sphere_mm * sphere_mm, 300);  // above the platform
  const Model inner = coloured::sphere(inner_mm, 160);
  model.places.insert(model.places.end(), inner.places.begin(), inner.places.end());
  model.uv.insert(model.uv.end(), inner.uv.begin(), inner.uv.end());
  const HiddenSurface both = hidden_of(model);
  const double half = 2 * pi * inner_mm * inner_mm;
  EXPECT_NEAR(both.hidden_mm2 - alone.hidden_mm2, half, 0.01 * half);
  EXPECT_NEAR(both.share(), both.hidden_mm2 / both.whole_mm2, 1e-12);
  ASSERT_EQ(both.largest.size(), alone.largest.size() + 1);
  const auto of_inner = std::find_if(both.largest.begin(), both.largest.end(), [&](const auto& area) {
    return std::abs(area.place.norm() - inner_mm) < 0.5;
  });
  ASSERT_NE(of_inner, both.largest.end());
  EXPECT_NEAR(of_inner->mm2, half, 0.01 * half);
}

TEST(ColouredSheet, IsTheSameWithOneThread) {
  const FileBytes scan = smooth_glb();
  const Printed many = printed(dome_sheet(), scan, "a.glb");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(printed(dome_sheet(), scan, "a.glb").rgba, many.rgba);
}

TEST(ColouredSheet, NeedsAScanWithColours) {
  const auto coloured = read_coloured_scan(shapes::stl(shapes::cube(100)), "a.stl", Context());
  ASSERT_FALSE(coloured);
  EXPECT_EQ(coloured.error().code, Code::unusable_scan);
  EXPECT_NE(coloured.error().text().find("no colours (STL (binary))"), std::string::npos)
      << coloured.error().text();
}

}  // namespace
}  // namespace vacuform
