#include "worker/scan/mold.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/decimal.hpp"
#include "worker/scan/closing.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/rebuilding.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/shells.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/upright.hpp"
#include "worker/scan/welding.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double weld_share = 1e-6;   // of the scan's size: what the rounding of floats makes of one point
constexpr double least_mold_mm = 20;  // height below which an automatic trim is refused
constexpr double undercut_mm = 1;     // shallower ones are noise, or give way when the part is lifted off
constexpr double undercut_mm2 = 20;   // seen from above: smaller ones do not set the trim
constexpr double reported_mm = 1.5;   // shallower ones lie within the grid of what the trim allows
constexpr double reported_mm2 = 4;    // smaller ones are a ray between two facets

std::string mm(double value) { return decimal(value, 1) + " mm"; }

// Half a millimetre on heads; coarser where a scan is so large that the grid would pass 800 columns a side.
double ray_spacing(const TriangleMesh& mesh) {
  return std::max(0.5, bounds(mesh).size().head<2>().maxCoeff() / 800);
}

void turn(TriangleMesh& mesh, const Eigen::Matrix3d& rotation, double scale) {
  for (auto& p : mesh.vertices) p = scale * (rotation * p);
}

void stand_on_floor(TriangleMesh& mesh, double floor) {
  for (auto& p : mesh.vertices) p.z() -= floor;
}

Eigen::Vector3d top_of(const TriangleMesh& mesh) {
  Eigen::Vector3d top = mesh.vertices.front();
  for (const auto& p : mesh.vertices)
    if (p.z() > top.z() || (p.z() == top.z() && p.head<2>().squaredNorm() < top.head<2>().squaredNorm()))
      top = p;
  return top;
}

// Millimetres per unit of the file, whose longest side is given in its unit.
Result<double> choose_scale(const ScanSettings& settings, const std::string& file_name, double longest,
                            ScanFindings& findings) {
  if (settings.size_mm) {
    findings.size_given = true;
    return *settings.size_mm / longest;
  }
  findings.unit = settings.units;
  if (settings.units == Unit::automatic) {
    VACUFORM_TRY(unit, guess_unit(longest, file_name));
    findings.unit = unit;
    findings.unit_guessed = true;
    return millimetres(unit);
  }
  const double side = longest * millimetres(findings.unit);
  if (side < 10 || side > 4000)
    return fail(Code::unusable_scan,
                "in " + std::string(name(findings.unit)) + " the scan's longest side is " +
                    (side < 10 ? "only " : "") + mm(side),
                file_name, "give another scan.units, or auto");
  return millimetres(findings.unit);
}

// Cuts at the height and puts the rest on the platform, in the middle, rounded to what mold.stl can hold so
// that the mesh and the file are one surface. Where that is not watertight, a hair higher it may be.
std::optional<TriangleMesh> cut_and_place(const TriangleMesh& mesh, double height) {
  for (const double raise : {0.0, 0.01, 0.02, 0.05}) {
    auto cut = cut_above(mesh, height + raise);
    if (!cut || cut->triangles.empty()) continue;
    const Eigen::Vector3d middle = bounds(*cut).centre();
    for (auto& p : cut->vertices)
      p = (p - Eigen::Vector3d(middle.x(), middle.y(), height + raise)).cast<float>().cast<double>();
    weld(*cut, 0);
    if (is_watertight(*cut)) return cut;
  }
  return std::nullopt;
}

// The closed mesh grown by the clearance. Where long thin triangles make that too dear, with wider facets. Heads and
// masks take 13 to 23 million tests.
Result<TriangleMesh> offset(const TriangleMesh& mesh, double clearance_mm, const ScanProgress& progress) {
  const double alpha = std::max(2.0, 0.01 * bounds(mesh).size().norm());
  const std::int64_t tests = 25'000'000 + 400 * static_cast<std::int64_t>(mesh.triangles.size());
  WrapBudget budget{tests};
  auto grown = wrap(mesh, alpha, clearance_mm, progress, budget);
  if (grown || grown.error().code == Code::cancelled) return grown;
  budget.tests = tests;
  return wrap(mesh, 2.5 * alpha, clearance_mm, progress, budget);
}

// The upright scan as a closed mesh; what lies below z = 0 is there to be cut off.
Result<TriangleMesh> close(const OuterSkin& skin, double clearance_mm, Mold& mold,
                           const ScanProgress& progress) {
  auto closing = skin.soup ? Closing{} : close_skin(skin.mesh);
  if (!closing.sound) {
    VACUFORM_TRY(rebuilt, rebuild(skin.mesh, progress));
    closing = {};
    closing.mesh = std::move(rebuilt);
    mold.findings.rebuilt = true;
  }
  mold.findings.holes_closed = closing.holes_closed;
  mold.findings.holes_capped = closing.holes_capped;
  if (closing.largest_filled_mm > 20)
    mold.warnings.push_back(
        {"large-hole",
         "A hole " + mm(closing.largest_filled_mm) + " across was filled; the mold is a guess there",
         {},
         Warning::Figure{closing.largest_filled_mm, "mm"}});
  if (clearance_mm == 0) return std::move(closing.mesh);
  return offset(closing.mesh, clearance_mm, progress);
}

// The height of the cut, given or chosen. Refuses one that leaves nothing, or next to nothing.
Result<void> trim(const TriangleMesh& closed, const ScanSettings& settings, const std::string& file_name,
                  ScanFindings& findings, const ScanProgress& progress) {
  const double height = bounds(closed).high.z();
  if (settings.trim_mm) {
    findings.trim_mm = *settings.trim_mm;
    if (findings.trim_mm > height - 1)
      return fail(Code::unusable_scan,
                  "the scan is " + mm(height) + " high and trimming it at " + mm(findings.trim_mm) +
                      " leaves nothing",
                  "scan.trim_mm", "give a smaller height");
    return {};
  }
  VACUFORM_TRY(space, CoveredSpace::measure(closed, 0, ray_spacing(closed), progress));
  findings.trim_mm = space.lowest_cut(undercut_mm, undercut_mm2);
  findings.trim_chosen = true;
  if (height - findings.trim_mm < least_mold_mm)
    return fail(Code::unusable_scan,
                "undercuts begin " + mm(findings.trim_mm) + " above the scan's lowest point, and only " +
                    mm(height - findings.trim_mm) + " of its " + mm(height) + " would remain as a mold",
                file_name,
                "turn the scan (scan.up, scan.roll_deg), or accept undercuts by giving the trim, for example "
                "--set scan.trim_mm=" +
                    std::to_string(static_cast<int>(height / 2)));
  return {};
}

Result<void> report_undercuts(Mold& mold, const ScanProgress& progress) {
  VACUFORM_TRY(space, CoveredSpace::measure(mold.mesh, 0, ray_spacing(mold.mesh), progress));
  for (const auto& undercut : space.undercuts(0))
    if (undercut.depth_mm > reported_mm && undercut.area_mm2 > reported_mm2)
      mold.undercuts.push_back(undercut);
  if (mold.undercuts.empty()) return {};
  mold.warnings.push_back(undercut_warning(mold.undercuts));
  return {};
}

}  // namespace

Result<Mold> make_mold(std::span<const std::uint8_t> bytes, const std::string& file_name,
                       const ScanSettings& settings, const Context& context) {
  ScanProgress progress(context);
  Mold mold;
  auto& findings = mold.findings;
  const auto warn = [&](std::string code, std::string text) {
    mold.warnings.push_back({std::move(code), std::move(text)});
  };
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
    return fail(Code::unusable_scan, "all triangles of the scan are without area", file_name,
                "export the scan again");
  VACUFORM_CHECK(progress.reach(0.3));

  // Millimetres, upright, standing on z = 0.
  VACUFORM_TRY(scale, choose_scale(settings, file_name, bounds(skin.mesh).size().maxCoeff(), findings));
  turn(skin.mesh, Eigen::Matrix3d::Identity(), scale);
  findings.up = settings.up;
  if (settings.up == UpAxis::automatic) {
    VACUFORM_TRY(guess, guess_up(skin.mesh, scan.y_up, progress));
    findings.up = guess.axis;
    findings.up_guessed = true;
    if (!guess.told)
      warn("up-guessed", "The up axis was taken to be " + std::string(name(guess.axis)) + " because " +
                             guess.why + "; give scan.up if the mold stands wrong");
  }
  turn(skin.mesh, upright_turn(findings.up, settings.roll_deg, settings.pitch_deg, settings.yaw_deg), 1);
  stand_on_floor(skin.mesh, bounds(skin.mesh).low.z());
  findings.size_mm = bounds(skin.mesh).size();

  VACUFORM_CHECK(progress.reach(0.35));

  VACUFORM_TRY(closed, close(skin, settings.clearance_mm, mold, progress));
  skin = {};
  VACUFORM_CHECK(progress.reach(0.6));
  VACUFORM_CHECK(trim(closed, settings, file_name, findings, progress));
  VACUFORM_CHECK(progress.reach(0.8));
  auto placed = cut_and_place(closed, findings.trim_mm);
  if (!placed && !findings.rebuilt) {  // the surface crosses itself at the cut
    VACUFORM_TRY(rebuilt, rebuild(closed, progress));
    findings.rebuilt = true;
    placed = cut_and_place(rebuilt, findings.trim_mm);
  }
  if (!placed)
    return fail(
        Code::unusable_scan, "no watertight mold can be made of the scan", file_name,
        "repair it in a mesh editor (close its holes, remove inner parts) or give another scan.trim_mm");
  if (findings.rebuilt)
    warn("rebuilt",
         "The scan's surface could not be closed as it is and was wrapped anew, up to 0.2 mm outside of it");

  mold.mesh = std::move(*placed);
  mold.top = top_of(mold.mesh);
  VACUFORM_CHECK(progress.reach(0.9));
  VACUFORM_CHECK(report_undercuts(mold, progress));
  VACUFORM_CHECK(progress.reach(1));
  return mold;
}

}  // namespace vacuform
