#include "worker/inspection/colour_errors.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "worker/colour/colour_difference.hpp"
#include "worker/png/png_reader.hpp"
#include "worker/printing/colour_ink.hpp"
#include "worker/printing/colour_raster.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/plane_locator.hpp"
#include "worker/surface/vertex_normals.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// How far beyond the end of all colour the scan is searched: the part of a pixel that has no colour is no further away.
constexpr double beyond_mm = 2;
const Vector2d to_sides[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
constexpr std::size_t shifts = std::size(register_errors_mm);

// What is found at one place of the print.
struct ComparedPlace {
  SheetPoint at;
  Vector3f formed;
  float area = 0;      // that the place stands for, mm2 of the formed sheet
  float position = 0;  // as in ColourErrors::Figures
  float along = NAN;   // NaN: the scan is too far away, also for `colour`
  float colour = NAN;
  bool touches = false;
  int towards = -1;  // the side that a pixel of full colour is shifted to; -1: another pixel, or in register
};
using Places = std::vector<const ComparedPlace*>;
struct ComparedRow {
  std::vector<ComparedPlace> in_register;
  std::array<std::vector<ComparedPlace>, shifts> off;
};

// The pixels of the print that are examined: every `step`-th of every `step`-th row.
struct PixelGrid {
  int step, first, first_row, rows, columns;

  PixelGrid(const PrintGrid& print, const PixelBox& box, double apart_mm)
      : step(std::max(1, static_cast<int>(std::lround(apart_mm / print.pixel_mm)))),
        first(step / 2),
        first_row(first + (std::max(0, box.top - first) + step - 1) / step * step),
        rows(std::max(0, (box.bottom - first_row + step - 1) / step)),
        columns((print.width - first + step - 1) / step) {}
  int row(int i) const { return first_row + i * step; }
  int column(int i) const { return first + i * step; }
};

// Their colours on white in linear light, row after row, before any mirroring.
std::vector<Vector3f> printed_colours(const Print& print, const PixelGrid& grid) {
  const Layer& layer = *print.coloured();
  std::vector<Vector3f> out;
  out.reserve(static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns));
  PngReader reader(layer.files.png);
  if (!reader.begin(PngReader::Rows::rgba8) || reader.passes() != 1)
    throw std::logic_error("the print cannot be read again");
  std::vector<std::uint8_t> line(reader.row_bytes());
  for (int i = 0, y = 0; i < grid.rows; ++i) {
    for (; y <= grid.row(i); ++y)
      if (!reader.row(line.data())) throw std::logic_error("the print cannot be read again");
    print.profile.convert_back(line);
    for (int k = 0; k < grid.columns; ++k) {
      const int x = layer.mirrored() ? print.grid.width - 1 - grid.column(k) : grid.column(k);
      const std::uint8_t* p = &line[4 * static_cast<std::size_t>(x)];
      Vector3f colour;
      for (int c = 0; c < 3; ++c)
        colour[c] =
            linear_from_srgb(1 + static_cast<float>(p[3]) / 255 * (static_cast<float>(p[c]) / 255 - 1));
      out.push_back(colour);
    }
  }
  return out;
}

class Comparison {
 public:
  Comparison(const Print& print, const ColourRaster& raster, const PixelGrid& grid)
      : colours_(*print.coloured()->source->colours()),
        print_(print.grid),
        grid_(grid),
        sheet_(colours_.on_sheet.sheet()),
        locator_(sheet_.triangles, sheet_.rest),
        origins_(static_cast<std::size_t>(grid.rows)) {
    together([&] { printed_ = printed_colours(print, grid); },
             [&] {
               in_parallel(0, grid.rows, [&](int first, int last) {
                 for (int i = first; i < last; ++i)
                   origins_[i] = raster.origins(grid.row(i), grid.first, grid.step);
               });
             });
  }

  ComparedRow row(int i) const {
    ComparedRow out;
    const int y = grid_.row(i);
    const auto& origins = origins_[i];
    for (int k = 0; k < grid_.columns; ++k) {
      const ColourRaster::Origin& origin = origins[k];
      if (!(origin.share > 0)) continue;
      const Vector3f& colour =
          printed_[static_cast<std::size_t>(i) * static_cast<std::size_t>(grid_.columns) +
                   static_cast<std::size_t>(k)];
      // Each quarter of the pixel in turn.
      const double right = (i + k) % 2 == 0 ? 0.25 : -0.25, down = (i + k) / 2 % 2 == 0 ? 0.25 : -0.25;
      const double d = print_.pixel_mm;
      const Vector2d rest((grid_.column(k) + 0.5 + right - print_.width / 2.0) * d,
                          (print_.height / 2.0 - y - 0.5 - down) * d);
      if (const auto at = locator_.find(rest)) out.in_register.push_back(compared(*at, origin.scan, colour));
      if (i % 2 != 0 || k % 2 != 0) continue;  // a quarter of the places is enough for these
      for (std::size_t s = 0; s < shifts; ++s)
        for (std::size_t side = 0; side < std::size(to_sides); ++side)
          if (const auto at = locator_.find(rest + register_errors_mm[s] * to_sides[side])) {
            out.off[s].push_back(compared(*at, origin.scan, colour));
            if (origin.share > 0.99) out.off[s].back().towards = static_cast<int>(side);
          }
    }
    return out;
  }

 private:
  ComparedPlace compared(const SheetPoint& at, const Vector3d& origin, const Vector3f& printed) const {
    const Triangle& corners = sheet_.triangles[at.triangle];
    const auto side = [&](const auto& of, std::size_t k) { return (of[corners[k]] - of[corners[0]]).eval(); };
    Eigen::Matrix2d flat;
    flat << side(sheet_.rest, 1), side(sheet_.rest, 2);
    Eigen::Matrix<double, 3, 2> formed_sides;
    formed_sides << side(sheet_.formed, 1), side(sheet_.formed, 2);
    const Eigen::Matrix<double, 3, 2> map = print_.pixel_mm * formed_sides * flat.inverse();
    const Vector3d formed = interpolate(sheet_.triangles, at, sheet_.formed);
    const double pixels = grid_.step * grid_.step;
    ComparedPlace out{.at = at, .formed = formed.cast<float>()};
    out.position = static_cast<float>((formed - origin).norm());
    out.area = static_cast<float>(pixels * map.col(0).cross(map.col(1)).norm());
    ColourWalk walk(colours_.on_sheet.surface(), map.col(0), -map.col(1));
    if (const auto there = walk.at(formed, colours_.on_sheet.reach().end_mm() + beyond_mm)) {
      out.along = static_cast<float>((there->place - origin).norm());
      out.colour = static_cast<float>(ciede2000(lab_of(seen(at, printed)), lab_of(there->linear)));
      out.touches = there->distance_mm <= colours_.on_sheet.reach().touch_mm;
    }
    return out;
  }

  Vector3f seen(const SheetPoint& at, const Vector3f& printed) const {
    if (!colours_.ink) return printed;
    const Triangle& corners = sheet_.triangles[at.triangle];
    double ratio = 0;
    for (int k = 0; k < 3; ++k)
      ratio += at.weights[k] * colours_.ink->area_ratios[corners[static_cast<std::size_t>(k)]];
    return colours_.ink->seen(printed, static_cast<float>(ratio));
  }

  const PrintedColours& colours_;
  const PrintGrid& print_;
  const PixelGrid& grid_;
  const FormedSheet& sheet_;
  PlaneLocator locator_;
  std::vector<std::vector<ColourRaster::Origin>> origins_;  // of each row, found while the print is read
  std::vector<Vector3f> printed_;
};

PlacedStatistics placed_statistics(const Places& all, float ComparedPlace::*value) {
  std::vector<Weighted> values;
  PlacedStatistics out;
  float largest = -1;
  for (const ComparedPlace* each : all) {
    const float v = each->*value;
    if (!std::isfinite(v)) continue;
    values.push_back({v, each->area});
    if (v > largest) largest = v, out.place = each->formed.cast<double>();
  }
  out.values = statistics(std::move(values));
  return out;
}

ColourErrors::Figures error_figures(const Places& all) {
  return {placed_statistics(all, &ComparedPlace::position), placed_statistics(all, &ComparedPlace::along),
          placed_statistics(all, &ComparedPlace::colour)};
}

// Means at the vertices of what is found in the triangles around them.
class AtVertices {
 public:
  explicit AtVertices(const FormedSheet& sheet)
      : sheet_(sheet), sum_(sheet.formed.size(), 0), weight_(sheet.formed.size(), 0) {}

  void add(const SheetPoint& at, double value) {
    if (!std::isfinite(value)) return;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(sheet_.triangles[at.triangle][k]);
      sum_[v] += at.weights[k] * value, weight_[v] += at.weights[k];
    }
  }
  // A vertex of small triangles that hold no place has the mean of its neighbours, if most have a value: not beyond
  // the edge.
  std::vector<double> means(const std::vector<int>& coloured) {
    std::vector<double> sum = sum_, weight = weight_;
    std::vector<int> without(sum.size(), 0);
    for (const int t : coloured)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = vertex(t, k);
        for (const std::size_t other : {vertex(t, (k + 1) % 3), vertex(t, (k + 2) % 3)})
          if (!(weight_[v] > 0)) {
            if (weight_[other] > 0)
              sum[v] += sum_[other] / weight_[other], ++weight[v];
            else
              ++without[v];
          }
      }
    std::vector<double> out(sum.size(), NAN);
    for (std::size_t v = 0; v < out.size(); ++v)
      if (weight[v] > 2 * without[v]) out[v] = sum[v] / weight[v];
    return out;
  }

 private:
  std::size_t vertex(int triangle, std::size_t k) const {
    return static_cast<std::size_t>(sheet_.triangles[triangle][k]);
  }

  const FormedSheet& sheet_;
  std::vector<double> sum_, weight_;
};

}  // namespace

Result<ColourErrors> colour_errors(const Print& print, double resolution_mm, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::inspection, 0));
  const SheetColours& colours = print.coloured()->source->colours()->on_sheet;
  const FormedSheet& sheet = colours.sheet();
  // So near that nearly every triangle of the sheet holds one.
  const double apart_mm = std::clamp(0.7 * resolution_mm, 0.7, 1.0);
  const ColourRaster raster(colours, print.grid);
  const PixelGrid grid(print.grid, raster.box(), apart_mm);
  const Comparison comparison(print, raster, grid);
  std::vector<ComparedRow> rows(static_cast<std::size_t>(grid.rows));
  constexpr int batch = 64;
  for (int begin = 0; begin < grid.rows; begin += batch) {
    VACUFORM_CHECK(context.step(Stage::inspection, static_cast<double>(begin) / grid.rows));
    in_parallel(begin, std::min(begin + batch, grid.rows), [&](int first, int last) {
      for (int i = first; i < last; ++i) rows[i] = comparison.row(i);
    });
  }

  ColourErrors out;
  AtVertices position(sheet), colour(sheet);
  Places whole, touching;
  for (const ComparedRow& row : rows)
    for (const ComparedPlace& each : row.in_register) {
      whole.push_back(&each);
      if (each.touches) touching.push_back(&each);
      position.add(each.at, each.position);
      colour.add(each.at, each.colour);
    }
  together([&] { out.whole = error_figures(whole); }, [&] { out.touching = error_figures(touching); });
  out.position_of_vertices = position.means(colours.triangles());
  out.colour_of_vertices = colour.means(colours.triangles());
  for (std::size_t s = 0; s < shifts; ++s) {
    touching.clear();
    for (const ComparedRow& row : rows)
      for (const ComparedPlace& each : row.off[s])
        if (each.touches) touching.push_back(&each);
    out.off_register.push_back({register_errors_mm[s], error_figures(touching)});
  }
  const std::vector<Vector3d> normals = vertex_normals(sheet.formed, sheet.triangles);
  double most = -1;
  for (std::size_t side = 0; side < std::size(to_sides); ++side) {
    AtVertices changed(sheet);
    for (const ComparedRow& row : rows)
      for (const ComparedPlace& each : row.off[shifts - 1])
        if (each.touches && each.towards == static_cast<int>(side)) changed.add(each.at, each.colour);
    const std::vector<double> changes = changed.means({});
    for (std::size_t v = 0; v < changes.size(); ++v)
      if (changes[v] > most) {
        most = changes[v];
        out.most_changed.place = sheet.formed[v];
        out.most_changed.outward = normals[v];
        out.most_changed.towards = to_sides[side];
      }
  }
  return out;
}

}  // namespace vacuform
