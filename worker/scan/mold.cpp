#include "worker/scan/mold.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "worker/scan/closing.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/shells.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/upright.hpp"
#include "worker/scan/welding.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double weld_share = 1e-6;       // of the scan's size: what the rounding of floats makes of one point
constexpr double least_mold_mm = 20;      // height below which an automatic trim is refused
constexpr double undercut_mm = 1;         // shallower ones are noise, or give way when the part is lifted off
constexpr double undercut_mm2 = 20;       // seen from above: smaller ones do not set the trim
constexpr double reported_mm = 1.5;       // shallower ones lie within the grid of what the trim allows
constexpr double wrap_offset_mm = 0.1;    // of a skin wrapped anew
constexpr double plate_depth_mm = 0.5;
constexpr double reported_mm2 = 4;        // smaller ones are a ray between two facets

std::string mm(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 1).ptr;
  return std::string(text, end) + " mm";
}

// Half a millimetre on heads; coarser where a scan is so large that the grid would pass 800 columns a side.
double ray_spacing(const TriangleMesh& mesh) { return std::max(0.5, bounds(mesh).size().head<2>().maxCoeff() / 800); }

void turn(TriangleMesh& mesh, const Eigen::Matrix3d& rotation, double scale) {
  for (auto& p : mesh.vertices) p = scale * (rotation * p);
}

void stand_on_floor(TriangleMesh& mesh, double floor) {
  for (auto& p : mesh.vertices) p.z() -= floor;
}

// A plate a little below the platform, as wide as the scan: it closes what is open below, and the cut takes it off.
TriangleMesh with_plate(TriangleMesh skin) {
  const Box box = bounds(skin);
  const int first = static_cast<int>(skin.vertices.size());
  for (const auto& [x, y] : {std::pair{box.low.x(), box.low.y()}, {box.high.x(), box.low.y()}, {box.high.x(), box.high.y()}, {box.low.x(), box.high.y()}})
    skin.vertices.emplace_back(x, y, -plate_depth_mm);
  skin.triangles.push_back({first, first + 1, first + 2});
  skin.triangles.push_back({first, first + 2, first + 3});
  return skin;
}

// A new skin around an upright scan that cannot be closed as it is. A wide bridging finds out what volume the scan
// encloses, and whether it is open below. Then the narrowest bridging that keeps the volume is taken: one that is too
// narrow slips through the scan's gaps and wraps its inside too.
Result<TriangleMesh> rebuild(const TriangleMesh& skin, const ScanProgress& progress) {
  const double size = bounds(skin).size().norm();
  VACUFORM_TRY(coarse, wrap(skin, 0.15 * size, wrap_offset_mm, progress));
  const TriangleMesh plated = with_plate(skin);
  VACUFORM_TRY(coarse_plated, wrap(plated, 0.15 * size, wrap_offset_mm, progress));
  const bool open_below = signed_volume(coarse) < 0.7 * signed_volume(coarse_plated);
  if (open_below) coarse = std::move(coarse_plated);
  for (const double alpha : {0.012 * size, 0.03 * size, 0.075 * size}) {
    VACUFORM_TRY(fine, wrap(open_below ? plated : skin, alpha, wrap_offset_mm, progress));
    if (signed_volume(fine) > 0.7 * signed_volume(coarse)) return fine;
  }
  return coarse;
}

// Rounds to what mold.stl can hold, so that the mesh and the file are the same surface.
void round_to_float(TriangleMesh& mesh) {
  for (auto& p : mesh.vertices) p = p.cast<float>().cast<double>();
  weld(mesh, 0);
}

Eigen::Vector3d top_of(const TriangleMesh& mesh) {
  Eigen::Vector3d top = mesh.vertices.front();
  for (const auto& p : mesh.vertices)
    if (p.z() > top.z() || (p.z() == top.z() && p.head<2>().squaredNorm() < top.head<2>().squaredNorm())) top = p;
  return top;
}

Result<void> choose_unit(const ScanSettings& settings, const std::string& file_name, double longest, ScanFindings& findings) {
  findings.unit = settings.units;
  if (settings.units == Unit::automatic) {
    VACUFORM_TRY(unit, guess_unit(longest, file_name));
    findings.unit = unit;
    findings.unit_guessed = true;
    return {};
  }
  const double side = longest * millimetres(findings.unit);
  if (side < 10 || side > 4000)
    return fail(Code::unusable_scan, "in " + std::string(name(findings.unit)) + " the scan's longest side is " +
                (side < 10 ? "only " : "") + mm(side), file_name, "give another scan.units, or auto");
  return {};
}

// Cuts; a border that crosses itself at just this height may not do so a hair higher.
std::optional<TriangleMesh> cut_near(const TriangleMesh& mesh, double height) {
  for (const double raise : {0.0, 0.01, 0.02, 0.05})
    if (auto cut = cut_above(mesh, height + raise)) {
      for (auto& p : cut->vertices) p.z() -= height + raise;
      return cut;
    }
  return std::nullopt;
}

}  // namespace

Result<Mold> make_mold(std::span<const std::uint8_t> bytes, const std::string& file_name, const ScanSettings& settings,
                       const Context& context) {
  ScanProgress progress(context);
  Mold mold;
  auto& findings = mold.findings;
  const auto warn = [&](std::string code, std::string text) { mold.warnings.push_back({std::move(code), std::move(text)}); };
  VACUFORM_CHECK(progress.reach(0));

  // The outer skin, in the file's unit and axes.
  VACUFORM_TRY(scan, read_scan(bytes, file_name, progress));
  findings.format = scan.format;
  findings.triangles_read = static_cast<std::int64_t>(scan.mesh.triangles.size());
  VACUFORM_CHECK(progress.reach(0.1));
  weld(scan.mesh, weld_share * robust_size(scan.mesh));
  VACUFORM_CHECK(progress.reach(0.15));
  VACUFORM_TRY(skin, outer_skin(scan.mesh, progress));
  scan.mesh = {};
  findings.components = skin.components;
  findings.components_dropped = skin.components_dropped;
  findings.turned_inside_out = skin.turned_inside_out;
  if (skin.mesh.triangles.empty() || !(bounds(skin.mesh).size().maxCoeff() > 0))
    return fail(Code::unusable_scan, "all triangles of the scan are without area", file_name, "export the scan again");
  VACUFORM_CHECK(progress.reach(0.3));

  // Millimetres, upright, standing on z = 0.
  VACUFORM_CHECK(choose_unit(settings, file_name, bounds(skin.mesh).size().maxCoeff(), findings));
  turn(skin.mesh, Eigen::Matrix3d::Identity(), millimetres(findings.unit));
  findings.up = settings.up;
  if (settings.up == UpAxis::automatic) {
    VACUFORM_TRY(guess, guess_up(skin.mesh, scan.y_up, progress));
    findings.up = guess.axis;
    findings.up_guessed = true;
    if (!guess.told)
      warn("up-guessed", "The up axis was taken to be " + std::string(name(guess.axis)) + " because " + guess.why +
                             "; give scan.up if the mold stands wrong");
  }
  turn(skin.mesh, upright_turn(findings.up, settings.roll_deg, settings.pitch_deg, settings.yaw_deg), 1);
  stand_on_floor(skin.mesh, bounds(skin.mesh).low.z());
  findings.size_mm = bounds(skin.mesh).size();

  // Closed.
  auto closing = skin.soup ? Closing{} : close_skin(skin.mesh);
  VACUFORM_CHECK(progress.reach(0.4));
  TriangleMesh closed = std::move(closing.mesh);
  findings.holes_closed = closing.holes_closed;
  findings.holes_capped = closing.holes_capped;
  const auto rebuild_skin = [&](const TriangleMesh& from) -> Result<void> {
    VACUFORM_TRY(wrapped, rebuild(from, progress));
    closed = std::move(wrapped);
    findings.rebuilt = true;
    warn("rebuilt", "The scan's surface could not be closed as it is and was wrapped anew, up to 0.2 mm outside of it");
    return {};
  };
  if (!closing.sound) VACUFORM_CHECK(rebuild_skin(skin.mesh));
  if (closing.largest_filled_mm > 20)
    warn("large-hole", "A hole " + mm(closing.largest_filled_mm) + " across was filled; the mold is a guess there");
  skin = {};
  double floor = 0;  // the scan's lowest point; walls and wraps reach below
  if (settings.clearance_mm > 0) {
    const double alpha = std::max(2.0, 0.01 * findings.size_mm.norm());
    VACUFORM_TRY(padded, wrap(closed, alpha, settings.clearance_mm, progress));
    closed = std::move(padded);
  }
  VACUFORM_CHECK(progress.reach(0.5));

  // Trimmed.
  if (settings.trim_mm) {
    findings.trim_mm = *settings.trim_mm;
  } else {
    VACUFORM_TRY(space, CoveredSpace::measure(closed, floor, ray_spacing(closed), progress));
    findings.trim_mm = space.lowest_cut(undercut_mm, undercut_mm2);
    findings.trim_chosen = true;
  }
  const double height = bounds(closed).high.z();
  if (settings.trim_mm && findings.trim_mm > height - 1)
    return fail(Code::unusable_scan, "the scan is " + mm(height) + " high and trimming it at " + mm(findings.trim_mm) + " leaves nothing",
                "scan.trim_mm", "give a smaller height");
  if (findings.trim_chosen && height - findings.trim_mm < least_mold_mm)
    return fail(Code::unusable_scan, "undercuts begin " + mm(findings.trim_mm) + " above the scan's lowest point, and only " +
                mm(height - findings.trim_mm) + " of its " + mm(height) + " would remain as a mold", file_name,
                "turn the scan (scan.up, scan.roll_deg), or accept undercuts by giving the trim, for example --set scan.trim_mm=" +
                    std::to_string(static_cast<int>(height / 2)));
  VACUFORM_CHECK(progress.reach(0.8));
  auto cut = cut_near(closed, floor + findings.trim_mm);
  if (cut) round_to_float(*cut);
  if ((!cut || !is_watertight(*cut)) && !findings.rebuilt) {
    VACUFORM_CHECK(rebuild_skin(closed));
    cut = cut_near(closed, floor + findings.trim_mm);
    if (cut) round_to_float(*cut);
  }
  if (!cut || cut->triangles.empty() || !is_watertight(*cut))
    return fail(Code::unusable_scan, "no watertight mold can be made of the scan", file_name,
                "repair it in a mesh editor (close its holes, remove inner parts) or give another scan.trim_mm");

  // Placed.
  const Box box = bounds(*cut);
  for (auto& p : cut->vertices) p -= Eigen::Vector3d(box.centre().x(), box.centre().y(), 0);
  round_to_float(*cut);
  mold.mesh = std::move(*cut);
  mold.top = top_of(mold.mesh);
  VACUFORM_CHECK(progress.reach(0.9));
  VACUFORM_TRY(space, CoveredSpace::measure(mold.mesh, 0, ray_spacing(mold.mesh), progress));
  for (const auto& undercut : space.undercuts(0))
    if (undercut.depth_mm > reported_mm && undercut.area_mm2 > reported_mm2) mold.undercuts.push_back(undercut);
  if (!mold.undercuts.empty()) {
    const auto& worst = mold.undercuts.front();
    const std::size_t count = mold.undercuts.size();
    warn("undercut", (count == 1 ? "The mold has an undercut that the sheet cannot reach or that locks the part; it"
                                 : "The mold has " + std::to_string(count) +
                                       " undercuts that the sheet cannot reach or that lock the part; the deepest") +
                         " reaches " + mm(worst.depth_mm) + " under what overhangs it at x = " + mm(worst.place.x()) +
                         ", y = " + mm(worst.place.y()) + ", z = " + mm(worst.place.z()));
  }
  VACUFORM_CHECK(progress.reach(1));
  return mold;
}

}  // namespace vacuform
