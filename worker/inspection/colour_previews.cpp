#include "worker/inspection/colour_previews.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "api/base/decimal.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/inspection/caption_words.hpp"
#include "worker/inspection/colour_errors.hpp"
#include "worker/inspection/side_marks.hpp"
#include "worker/inspection/tiles.hpp"
#include "worker/printing/colour_ink.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A scan with more vertices gets no shadows of its own, because they take longer than everything else.
constexpr std::size_t most_shadowed = 300'000;
constexpr double detail_mm = 15;  // what is shown around a place, each way

// The part of a scan above the platform, its vertices joined where they are equal, so that it is shaded smoothly.
struct ShownScan {
  TriangleMesh mesh;
  std::vector<int> triangle;  // of the scan
};

ShownScan shown_scan(const TriangleMesh& scan) {
  const auto before = [&](int a, int b) {
    const Vector3d &p = scan.vertices[a], &q = scan.vertices[b];
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  std::vector<int> order(scan.vertices.size()), joined(scan.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), before);
  ShownScan out;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto v = static_cast<std::size_t>(order[i]);
    if (i == 0 || before(order[i - 1], order[i])) out.mesh.vertices.push_back(scan.vertices[v]);
    joined[v] = static_cast<int>(out.mesh.vertices.size()) - 1;
  }
  for (std::size_t t = 0; t < scan.triangles.size(); ++t) {
    Triangle corners;
    double highest = -INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(scan.triangles[t][k]);
      corners[k] = joined[v];
      highest = std::max(highest, scan.vertices[v].z());
    }
    if (!(highest > 0)) continue;
    out.mesh.triangles.push_back(corners);
    out.triangle.push_back(static_cast<int>(t));
  }
  return out;
}

std::string millimetres(double mm, int places = 2) { return decimal(mm, places) + " mm"; }

std::string position_words(const PlacedStatistics& position) {
  return "mean " + millimetres(position.values.mean) + ", 99 % below " + millimetres(position.values.p99);
}

// The side that looks most straight at a surface.
View::Side side_before(const Vector3d& outward) {
  if (outward.z() > 0.75) return View::Side::above;
  if (std::abs(outward.x()) > std::abs(outward.y()))
    return outward.x() < 0 ? View::Side::minus_x : View::Side::plus_x;
  return outward.y() > 0 ? View::Side::straight_front : View::Side::straight_back;
}

std::string direction_words(const Vector2d& towards) {
  if (towards.x() != 0) return towards.x() > 0 ? "the right (+s)" : "the left (-s)";
  return towards.y() > 0 ? "the front (+t)" : "the back (-t)";
}

}  // namespace

Result<Picture> original_preview(const Finished& job, const View& view, const std::vector<Picture>& formed,
                                 const Context& context) {
  const SheetColours& colours = job.print.coloured()->source->colours()->on_sheet;
  const ColouredSurface& surface = colours.surface();
  ShownScan scan = shown_scan(surface.mesh());
  const bool shadows = scan.mesh.vertices.size() <= most_shadowed;
  View of_scan(std::move(scan.mesh), view.shown(), view.letters(), tile_width, tile_height, tile_label, 0,
               shadows);
  Tiles tiles(static_cast<int>(tile_columns * std::size(five_sides)));
  for (std::size_t i = 0; i < std::size(five_sides); ++i) {
    const std::string words = side_words(five_sides[i], view.letters());
    of_scan.look_from(five_sides[i], tile_width, tile_height, tile_label, 0);
    VACUFORM_TRY(pictures,
                 of_scan.draw(
                     1,
                     [&](const Seen& seen, Rgb* colour) {
                       const Eigen::Vector3f linear = surface.colour(
                           scan.triangle[seen.triangle], Vector3d(seen.weights.data()), seen.spacing_mm);
                       *colour = seen.light * linear.unaryExpr(&srgb_from_linear) + Rgb::Constant(seen.gloss);
                     },
                     context, 0.76 + 0.01 * static_cast<double>(i), 0.77 + 0.01 * static_cast<double>(i)));
    tiles.put(static_cast<int>(tile_columns * i), pictures.front(), "Scan: " + words);
    tiles.put(static_cast<int>(tile_columns * i + 1), formed[i], "Formed part: " + words);
  }
  const ColourErrors::Figures& errors = job.figures.errors->touching;
  return tiles.finished({"The scan and the formed part",
                         "where the sheet touches: off by " + millimetres(errors.position.values.mean) +
                             " on average, colour difference (CIEDE2000) " +
                             decimal(errors.colour.values.mean, 2) + " on average",
                         {},
                         colours_caption(colours.area().faded_share())});
}

Result<Picture> align_preview(const Finished& job, View& view, const ShadeShifted& shade,
                              const Context& context) {
  const ColourErrors& errors = *job.figures.errors;
  const ColourErrors::Change& change = errors.most_changed;
  const View::Side side = side_before(change.outward);
  const std::vector<Vector3d> whole = view.shown();
  std::vector<Vector3d> detail;
  for (int axis = 0; axis < 3; ++axis)
    for (const double way : {-detail_mm, detail_mm})
      detail.push_back(change.place + way * Vector3d::Unit(axis));
  const std::size_t rows = 1 + errors.off_register.size();
  Tiles tiles(static_cast<int>(tile_columns * rows));
  for (const bool near : {false, true}) {
    view.show(near ? detail : whole, near);
    view.look_from(side, tile_width, tile_height, tile_label, 0);
    VACUFORM_TRY(pictures,
                 view.draw(
                     static_cast<int>(rows),
                     [&](const Seen& seen, Rgb* colours) {
                       for (std::size_t i = 0; i < rows; ++i)
                         shade(seen, (i == 0 ? 0.0 : errors.off_register[i - 1].shift_mm) * change.towards,
                               &colours[i]);
                     },
                     context, near ? 0.83 : 0.81, near ? 0.85 : 0.83));
    for (std::size_t i = 0; i < rows; ++i) {
      const std::string name =
          i == 0 ? "In register" : short_decimal(errors.off_register[i - 1].shift_mm, 2) + " mm off";
      const auto& of_row = i == 0 ? errors.touching : errors.off_register[i - 1].touching;
      tiles.put(static_cast<int>(tile_columns * i + (near ? 1 : 0)), pictures[i],
                near ? position_words(of_row.position) : name);
    }
  }
  view.show(whole, false);
  std::string place;
  for (int axis = 0; axis < 3; ++axis) place += (axis == 0 ? "" : ", ") + decimal(change.place[axis], 0);
  return tiles.finished(
      {"The print laid off its registration marks",
       "moved towards " + direction_words(change.towards) +
           " on the flat sheet; on the right the part around (" + place + ") mm",
       {},
       "Figures: how far colours lie off where the sheet touches, for shifts in all four directions."});
}

}  // namespace vacuform
